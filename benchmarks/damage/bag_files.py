"""Small ROS bags of a drive outdoors, written by another library: whole ones, and with faults of drivers."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from handcart.robotics.numerics.arrays import FloatArray, IntArray

PERIOD_S = 0.05  # [s]
LATITUDE, LONGITUDE, METRES = 48.0, 9.0, 111_320.0
START_TIME_S = 1_700_000_000.0  # [s] since 1970
TOPIC_TYPES = {
    "/imu": "sensor_msgs/msg/Imu",
    "/odom": "nav_msgs/msg/Odometry",
    "/fix": "sensor_msgs/msg/NavSatFix",
    "/truth": "geometry_msgs/msg/PoseStamped",
}
Stamp = Callable[[str, float], float]


class BagDrive(NamedTuple):
    """Messages that a vehicle's drivers publish."""

    times: FloatArray
    """(n,) from 0 on, in [s]."""
    poses: FloatArray
    """(n, 3) the truth: x, y in [m], heading in [rad]."""
    rates: FloatArray
    """(n, 3) of the gyros, in [rad/s]."""
    accelerations: FloatArray
    """(n, 3) in [m/s²]."""
    speeds: FloatArray
    """(n,) by the wheels, in [m/s]."""
    turns: FloatArray
    """(n,) turn rate by the wheels, in [rad/s]."""
    fix_rows: IntArray
    """(m,) at which a fix comes in."""
    places: FloatArray
    """(m, 2) latitude and longitude, in [deg]."""
    variance: float = 0.25
    """Stated of a fix, an axis, in [m²]; 0: nothing is stated."""


def small_drive(seed: int = 1, duration: float = 60.0) -> BagDrive:
    """Return a winding drive at 1 m/s with a fix each second."""
    rng = np.random.default_rng(seed)
    times = np.arange(0.0, duration, PERIOD_S)
    turns = 0.15 * np.sin(times / 6.0)
    headings = np.cumsum(turns) * PERIOD_S
    x, y = np.cumsum(np.cos(headings)) * PERIOD_S, np.cumsum(np.sin(headings)) * PERIOD_S
    rates = np.stack([np.zeros(len(times)), np.zeros(len(times)), turns], axis=1)
    rows = np.arange(0, len(times), round(1.0 / PERIOD_S))
    away = 0.5 * rng.standard_normal((len(rows), 2))
    return BagDrive(
        times,
        np.stack([x, y, headings], axis=1),
        rates + 0.002 * rng.standard_normal(rates.shape),
        np.tile([0.0, 0.0, 9.81], (len(times), 1)) + 0.05 * rng.standard_normal((len(times), 3)),
        np.ones(len(times)),
        turns,
        rows,
        as_degrees(np.stack([x[rows], y[rows]], axis=1) + away),
    )


def as_degrees(places: FloatArray) -> FloatArray:
    """Return latitude and longitude (m, 2) in [deg] of places (m, 2) east and north in [m]."""
    latitudes = LATITUDE + places[:, 1] / METRES
    return np.stack(
        [latitudes, LONGITUDE + places[:, 0] / (METRES * math.cos(math.radians(LATITUDE)))], axis=1
    )


def write_bag(
    path: Path,
    drive: BagDrive,
    storage: str = "SQLITE3",
    stamp: Stamp = lambda topic, time: START_TIME_S + time,
    topics: dict[str, str] = TOPIC_TYPES,
    compression: str = "NONE",
) -> Path:
    """Write a bag of rosbag2; of ROS 1 if `storage` is ROS1.

    Args:
        path: a folder that doesn't exist yet; a .bag file for ROS 1.
        drive: the published messages.
        storage: SQLITE3, MCAP or ROS1.
        stamp: returns the header stamp of a message, by topic and time, in [s].
        topics: the topics to write, each with its declared type.
        compression: the part that is compressed with zstd: NONE, FILE, MESSAGE, or STORAGE (chunks of
            MCAP).
    """
    from rosbags.rosbag1 import Writer as Writer1
    from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin
    from rosbags.rosbag2 import Writer as Writer2
    from rosbags.typesys import Stores, get_typestore

    is_ros1 = storage == "ROS1"
    store: Any = get_typestore(Stores.ROS1_NOETIC if is_ros1 else Stores.ROS2_HUMBLE)
    writer: Any = (
        Writer1(path) if is_ros1 else Writer2(path, version=8, storage_plugin=StoragePlugin[storage])
    )
    if compression != "NONE":
        writer.set_compression(CompressionMode[compression], CompressionFormat.ZSTD)
    fixes = dict(zip(drive.fix_rows.tolist(), drive.places, strict=True))
    with writer:
        connections = {
            topic: writer.add_connection(topic, kind, typestore=store) for topic, kind in topics.items()
        }
        for row, time in enumerate(drive.times.tolist()):
            for topic in topics:
                if TOPIC_TYPES[topic] == TOPIC_TYPES["/fix"] and row not in fixes:
                    continue
                head = _header(store, stamp(topic, time), row)
                content = _content(store, topic, drive, row, fixes, head)
                encode = store.serialize_ros1 if is_ros1 else store.serialize_cdr
                raw = bytes(encode(content, TOPIC_TYPES[topic]))
                writer.write(connections[topic], round(1e9 * (START_TIME_S + time)), raw)
    return path


def _header(store: Any, stamp: float, row: int) -> Any:
    kinds = store.types
    time = kinds["builtin_interfaces/msg/Time"](sec=int(stamp), nanosec=int(1e9 * (stamp % 1.0)))
    head = kinds["std_msgs/msg/Header"]
    return head(row, time, "base_link") if "seq" in head.__dataclass_fields__ else head(time, "base_link")


def _content(
    store: Any, topic: str, drive: BagDrive, row: int, fixes: dict[int, FloatArray], head: Any
) -> Any:
    kinds = store.types
    vector, turned = kinds["geometry_msgs/msg/Vector3"], kinds["geometry_msgs/msg/Quaternion"]
    x, y, heading = drive.poses[row].tolist()
    pose = kinds["geometry_msgs/msg/Pose"](
        kinds["geometry_msgs/msg/Point"](x, y, 0.0),
        turned(0.0, 0.0, math.sin(heading / 2.0), math.cos(heading / 2.0)),
    )
    kind, none9, none36 = kinds[TOPIC_TYPES[topic]], np.zeros(9), np.zeros(36)
    if topic == "/imu":
        rates, felt = vector(*drive.rates[row].tolist()), vector(*drive.accelerations[row].tolist())
        return kind(head, turned(0.0, 0.0, 0.0, 1.0), none9, rates, none9, felt, none9)
    if topic == "/odom":
        twist = kinds["geometry_msgs/msg/Twist"](
            vector(float(drive.speeds[row]), 0.0, 0.0), vector(0.0, 0.0, float(drive.turns[row]))
        )
        spread = kinds["geometry_msgs/msg/PoseWithCovariance"](pose, none36)
        return kind(head, "base_link", spread, kinds["geometry_msgs/msg/TwistWithCovariance"](twist, none36))
    if topic == "/truth":
        return kind(head, pose)
    latitude, longitude = fixes[row].tolist()
    status = kinds["sensor_msgs/msg/NavSatStatus"](status=0, service=1)
    covariance = np.diag([drive.variance] * 3).ravel()
    stated = 2 if drive.variance > 0.0 else 0
    return kind(head, status, latitude, longitude, 0.0, covariance, stated)
