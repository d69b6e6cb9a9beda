"""Reading of a ROS bag (rosbag2 with SQLite or MCAP, and rosbag1) as a recorded log."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np

from handcart.evaluation.offline_localization.checks.stamps import check_offsets, check_stamps
from handcart.evaluation.offline_localization.logs.csv_log import first_place, held_on, plane
from handcart.evaluation.offline_localization.logs.drive_log import DriveLog
from handcart.evaluation.offline_localization.logs.places import checked_places
from handcart.files.errors import FileError, Finding, InputError
from handcart.files.extras import lack
from handcart.files.suggest import listed
from handcart.robotics.geometry.pose2 import heading_of

from .bag_messages import Bag, BagError, BagMessage, read_bag

IMU, ODOMETRY, FIX = "sensor_msgs/msg/Imu", "nav_msgs/msg/Odometry", "sensor_msgs/msg/NavSatFix"
POSE_TYPES = (ODOMETRY, "geometry_msgs/msg/PoseStamped", "geometry_msgs/msg/PoseWithCovarianceStamped")
NO_FIX = -1  # of NavSatFix.status
MAX_UNREADABLE = 0.5  # share of a topic's messages: with more it has another type
MIN_SIGMA_M = 1e-3  # smaller stated errors are ignored
READING_LIMITS = {"rates": 100.0, "accelerations": 1000.0, "speed": 150.0, "turn": 100.0, "reference": 1e7}
"""Largest plausible readings, in SI units."""
Stamps = Literal["header", "receive"]


class _Row(NamedTuple):
    """Time and content of a message; quantities that it does not hold are NaN."""

    time: float
    topic: str
    rates: tuple[float, ...] = (math.nan,) * 3
    accelerations: tuple[float, ...] = (math.nan,) * 3
    speed: float = math.nan
    turn: float = math.nan
    place: tuple[float, float] = (math.nan, math.nan)
    sigma: float = math.nan
    reference: tuple[float, float, float] = (math.nan,) * 3


def read_bag_log(path: Path, reference: str | None = None, stamps: Stamps = "header") -> DriveLog:
    """Read the log in a bag: its first Odometry topic, and its first Imu and NavSatFix topics if present.

    The IMU's axes are assumed to be the base's, and Odometry's twist to be the base's speed and turn rate.
    Without an Imu topic the turn rate of the twist is used.

    Args:
        path: a folder of rosbag2, or a .mcap, .db3 or .bag file.
        reference: a topic with the true poses (Odometry, PoseStamped, PoseWithCovarianceStamped).
        stamps: whether a message's time is that of its header, or that of its recording.

    Raises:
        InputError: the extra `bags` is not installed.
        FileError: the bag cannot be read, lacks a required topic, or its stamps are not usable as
            times.
    """
    missing = lack("a ROS bag", "bags")
    if missing is not None:
        raise InputError(missing)
    try:
        bag = read_bag(path, {IMU, FIX, *POSE_TYPES})
    except BagError as error:
        raise FileError([Finding(str(path), 0, 0, str(error))]) from None
    chosen = _chosen(path, bag.topics, reference)
    messages = [message for message in bag.messages if message.topic in chosen]
    notes = [*bag.notes, *_readable(path, bag, messages, chosen)]
    timed = _timed(path, messages, stamps, notes)
    rows = sorted((_row(time, message, reference) for time, message in timed), key=lambda row: row.time)
    rows = _plausible(path, rows, notes)
    return _log(path, rows, notes, has_imu=IMU in chosen.values())


def _chosen(path: Path, topics: dict[str, str], reference: str | None) -> dict[str, str]:
    """Return the used topics with their types."""
    found = {
        kind: next((topic for topic, text in topics.items() if text == kind and topic != reference), None)
        for kind in (IMU, ODOMETRY, FIX)
    }
    wrong = []
    if found[ODOMETRY] is None:
        wrong.append(f"no {ODOMETRY} in it; needed: how fast the wheels turn")
        if found[IMU] is None:
            wrong.append(f"no {IMU} in it; needed: gyros, or Odometry's twist")
    if reference is not None and topics.get(reference) not in POSE_TYPES:
        poses = [topic for topic, kind in topics.items() if kind in POSE_TYPES]
        wrong.append(f"no poses on the topic {reference!r}; allowed: {listed(poses)}")
    if wrong:
        raise FileError([Finding(str(path), 0, 0, item) for item in wrong])
    chosen = {topic: kind for kind, topic in found.items() if topic is not None}
    return chosen if reference is None else chosen | {reference: topics[reference]}


def _count(messages: list[BagMessage], topic: str) -> int:
    return sum(message.topic == topic for message in messages)


def _readable(path: Path, bag: Bag, messages: list[BagMessage], chosen: dict[str, str]) -> list[str]:
    """Return notes about messages that cannot be decoded.

    Raises:
        FileError: a topic has no messages, or most of its messages cannot be decoded.
    """
    notes, wrong = list[str](), list[str]()
    for topic, kind in chosen.items():
        bad, good = bag.unreadable.get(topic, 0), _count(messages, topic)
        if bad > MAX_UNREADABLE * (good + bad):
            wrong.append(f"{topic}: {bad} of {good + bad} messages can't be read as {kind}")
        elif bad:
            notes.append(f"{topic}: {bad} of {good + bad} messages can't be read; they are skipped")
        elif not good:
            wrong.append(f"{topic}: no messages; needed: at least two")
    if wrong:
        raise FileError([Finding(str(path), 0, 0, item) for item in wrong])
    return notes


def _timed(
    path: Path, messages: list[BagMessage], stamps: Stamps, notes: list[str]
) -> list[tuple[float, BagMessage]]:
    """Return each message with its time, without messages whose stamp is unusable.

    Raises:
        FileError: the header stamps of a topic are not usable as times.
    """
    if stamps == "receive":
        notes.append("played by the times at which the messages were recorded, not by their header stamps")
        return [(message.received, message) for message in messages]
    found, unusable, delays = list[tuple[float, BagMessage]](), list[str](), dict[str, float]()
    for topic in dict.fromkeys(message.topic for message in messages):
        of_topic = [message for message in messages if message.topic == topic]
        heads = np.array([_stamp(message.content) for message in of_topic])
        received = np.array([message.received for message in of_topic])
        report = check_stamps(topic, heads, received)
        notes += report.notes
        if report.unusable:
            unusable.append(report.unusable)
        elif report.used.any():
            delays[topic] = float(np.median((received - heads)[report.used]))
        found += [(heads[k], of_topic[k]) for k in np.flatnonzero(report.used)]
    more, apart = check_offsets(delays)
    notes += more
    unusable += [apart] if apart else []
    if unusable:
        allowed = "allowed: stamps that rise; or --stamps receive: the times at which messages were recorded"
        raise FileError([Finding(str(path), 0, 0, f"{item}; {allowed}") for item in unusable])
    return found


def _stamp(message: Any) -> float:
    stamp = message.header.stamp
    return float(stamp.sec + 1e-9 * stamp.nanosec)


def _plausible(path: Path, rows: list[_Row], notes: list[str]) -> list[_Row]:
    """Return the rows whose readings are plausible for a vehicle.

    Raises:
        FileError: most readings of a topic exceed `READING_LIMITS`.
    """
    beyond = np.zeros(len(rows), dtype=bool)
    for name, limit in READING_LIMITS.items():
        values = np.array([getattr(row, name) for row in rows]).reshape(len(rows), -1)
        beyond |= (np.abs(values) > limit).any(axis=1)
    wrong = list[str]()
    for topic in dict.fromkeys(row.topic for row, bad in zip(rows, beyond, strict=True) if bad):
        of_topic = np.array([row.topic == topic for row in rows])
        bad, count = int((of_topic & beyond).sum()), int(of_topic.sum())
        words = f"{topic}: {bad} of {count} readings are beyond any vehicle's"
        (wrong if bad > MAX_UNREADABLE * count else notes).append(words)
    if wrong:
        raise FileError([Finding(str(path), 0, 0, f"{text}; needed: SI units") for text in wrong])
    return [row for row, bad in zip(rows, beyond, strict=True) if not bad]


def _row(time: float, message: BagMessage, reference: str | None) -> _Row:
    topic, content = message.topic, message.content
    if topic == reference:
        pose = content.pose
        pose = getattr(pose, "pose", pose)
        turned = pose.orientation
        heading = heading_of(turned.x, turned.y, turned.z, turned.w)
        return _Row(time, topic, reference=(pose.position.x, pose.position.y, heading))
    if message.kind == IMU:
        turn, felt = content.angular_velocity, content.linear_acceleration
        return _Row(time, topic, (turn.x, turn.y, turn.z), (felt.x, felt.y, felt.z))
    if message.kind == ODOMETRY:
        twist = content.twist.twist
        return _Row(time, topic, speed=twist.linear.x, turn=twist.angular.z)
    if content.status.status <= NO_FIX:
        return _Row(time, topic)
    variance = float(content.position_covariance[0] + content.position_covariance[4]) / 2.0
    known = content.position_covariance_type > 0 and MIN_SIGMA_M**2 < variance < math.inf
    sigma = math.sqrt(variance) if known else math.nan
    return _Row(time, topic, place=(content.latitude, content.longitude), sigma=sigma)


def _log(path: Path, rows: list[_Row], notes: list[str], has_imu: bool) -> DriveLog:
    if len(rows) < 2:
        raise FileError([Finding(str(path), 0, 0, "no readings; needed: at least two messages")])
    times, _, rates, felt, speeds, turns, places, sigmas, reference = (
        np.array(item) for item in zip(*rows, strict=True)
    )
    way = held_on(speeds) * np.diff(times, prepend=times[0])
    latitudes, longitudes, wrong = checked_places(places[:, 0], places[:, 1], times)
    fixes = plane(latitudes, longitudes, first_place(latitudes, longitudes))
    if not has_imu:
        notes = [*notes, f"no {IMU} in it: it turns as Odometry's twist says"]
        rates = np.stack([np.zeros(len(times)), np.zeros(len(times)), held_on(turns)], axis=1)
        felt = np.tile([0.0, 0.0, 9.81], (len(times), 1))
    nowhere = (math.nan,) * 3
    wheels = np.stack([way, way], axis=1)
    return DriveLog(
        times - times[0],
        rates,
        felt,
        wheels,
        fixes,
        sigmas,
        reference,
        nowhere,
        None,
        steered=not has_imu,
        odometry_turns=turns,
        notes=(*notes, *wrong),
    )
