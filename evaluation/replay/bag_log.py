"""Reading a ROS bag (rosbag2 with SQLite or MCAP, and rosbag1) as a recorded log."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from handcart.files.errors import FileError, Finding, InputError
from handcart.files.extras import lack
from handcart.files.suggest import listed

from .csv_log import first_place, held_on, plane
from .drive_log import DriveLog

IMU, ODOMETRY, FIX = "sensor_msgs/msg/Imu", "nav_msgs/msg/Odometry", "sensor_msgs/msg/NavSatFix"
NEEDED = {IMU: "gyros and accelerometers", ODOMETRY: "how fast the wheels turn"}
POSES = (ODOMETRY, "geometry_msgs/msg/PoseStamped", "geometry_msgs/msg/PoseWithCovarianceStamped")
NO_FIX = -1  # of NavSatFix.status
Array = NDArray[np.float64]


class _Row(NamedTuple):
    """A message: when, and what it tells; NaN for the rest."""

    time: float
    rates: tuple[float, ...] = (math.nan,) * 3
    accelerations: tuple[float, ...] = (math.nan,) * 3
    speed: float = math.nan
    place: tuple[float, float] = (math.nan, math.nan)
    sigma: float = math.nan
    reference: tuple[float, float, float] = (math.nan,) * 3


def read_bag_log(path: Path, reference: str | None = None) -> DriveLog:
    """The log in a bag: its first Imu and Odometry topic, and its first NavSatFix topic if it has one.

    The inertial unit's axes are taken to be the base's, and Odometry's twist its speed.

    Args:
        path: a folder of rosbag2, or a .bag file.
        reference: a topic with the true poses (Odometry, PoseStamped, PoseWithCovarianceStamped).

    Raises:
        InputError: the extra `bags` isn't installed.
        FileError: it can't be read, or lacks what is needed.
    """
    missing = lack("a ROS bag", "bags")
    if missing is not None:
        raise InputError(missing)
    from rosbags.highlevel import AnyReader, AnyReaderError
    from rosbags.typesys import Stores, get_typestore

    where = path.parent if path.suffix in (".db3", ".mcap") else path
    try:
        with AnyReader([where], default_typestore=get_typestore(Stores.LATEST)) as reader:
            chosen = _chosen(path, reader.connections, reference)
            rows = [
                _row(reader.deserialize(raw, connection.msgtype), connection, reference)
                for connection, _, raw in reader.messages(chosen)
            ]
    except FileError:
        raise
    except (AnyReaderError, OSError, ValueError, KeyError) as error:
        wrong = (
            f"no bag that can be read: {str(error).splitlines()[0] if str(error) else type(error).__name__}"
        )
        raise FileError(
            [Finding(str(path), 0, 0, f"{wrong}; allowed: rosbag2 (SQLite, MCAP), rosbag1")]
        ) from None
    return _log(path, sorted(rows, key=lambda row: row.time))


def _chosen(path: Path, connections: list[Any], reference: str | None) -> list[Any]:
    found = {
        kind: next((each for each in connections if each.msgtype == kind and each.topic != reference), None)
        for kind in (IMU, ODOMETRY, FIX)
    }
    wrong = [f"no {kind} in it; needed: {what}" for kind, what in NEEDED.items() if found[kind] is None]
    true = next((each for each in connections if each.topic == reference), None)
    if reference is not None and (true is None or true.msgtype not in POSES):
        poses = [each.topic for each in connections if each.msgtype in POSES]
        wrong.append(f"no poses on the topic {reference!r}; allowed: {listed(poses)}")
    if wrong:
        raise FileError([Finding(str(path), 0, 0, each) for each in wrong])
    return [each for each in (*found.values(), true) if each is not None]


def _row(message: Any, connection: Any, reference: str | None) -> _Row:
    stamp = message.header.stamp
    time = stamp.sec + 1e-9 * stamp.nanosec
    if connection.topic == reference:
        pose = message.pose
        pose = getattr(pose, "pose", pose)
        turned = pose.orientation
        sin = 2.0 * (turned.w * turned.z + turned.x * turned.y)
        cos = 1.0 - 2.0 * (turned.y**2 + turned.z**2)
        return _Row(time, reference=(pose.position.x, pose.position.y, math.atan2(sin, cos)))
    if connection.msgtype == IMU:
        turn, felt = message.angular_velocity, message.linear_acceleration
        return _Row(time, (turn.x, turn.y, turn.z), (felt.x, felt.y, felt.z))
    if connection.msgtype == ODOMETRY:
        return _Row(time, speed=message.twist.twist.linear.x)
    if message.status.status <= NO_FIX:
        return _Row(time)
    variance = float(message.position_covariance[0] + message.position_covariance[4]) / 2.0
    known = message.position_covariance_type > 0 and variance > 0.0
    sigma = math.sqrt(variance) if known else math.nan
    return _Row(time, place=(message.latitude, message.longitude), sigma=sigma)


def _log(path: Path, rows: list[_Row]) -> DriveLog:
    if len(rows) < 2:
        raise FileError([Finding(str(path), 0, 0, "no readings; needed: at least two messages")])
    times, rates, felt, speeds, places, sigmas, reference = (
        np.array(each) for each in zip(*rows, strict=True)
    )
    way = held_on(speeds) * np.diff(times, prepend=times[0])
    fixes = plane(places[:, 0], places[:, 1], first_place(places[:, 0], places[:, 1]))
    nowhere = (math.nan,) * 3
    wheels = np.stack([way, way], axis=1)
    return DriveLog(times - times[0], rates, felt, wheels, fixes, sigmas, reference, nowhere, None)
