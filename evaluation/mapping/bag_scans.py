"""Reader of scans with odometry in a ROS bag (rosbag2 with SQLite or MCAP, and rosbag1)."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from handcart.evaluation.offline_localization.bags.bag_messages import Bag, BagError, BagMessage, read_bag
from handcart.evaluation.offline_localization.checks.stamps import check_stamps
from handcart.files.errors import FileError, Finding, InputError
from handcart.files.extras import lack
from handcart.files.suggest import listed, suggest
from handcart.robotics.geometry.pose2 import Pose2, heading_of
from handcart.robotics.navigation.mapping.scan_log import ScanLog
from handcart.robotics.numerics.arrays import FloatArray

from .bag_angles import angle_notes, angles_in_words, has_usable_angles, scan_arrays
from .odometry_track import poses_at

SCAN, ODOMETRY, TRANSFORMS = "sensor_msgs/msg/LaserScan", "nav_msgs/msg/Odometry", "tf2_msgs/msg/TFMessage"
OLD_TRANSFORMS = "tf/msg/tfMessage"
ODOM_FRAMES = ("odom", "odom_combined", "odometry")
MAX_COORDINATE_M = 1e6
"""Distance from the origin beyond which poses of the odometry are ignored, such as coordinates of UTM."""


def read_bag_scans(path: Path, scan_topic: str | None = None) -> ScanLog:
    """Read lidar scans and odometry from a ROS bag.

    The odometry is that of the first Odometry topic; without such a topic, it is read from tf. The mounting
    of the lidar is read from tf as well; scans of a lidar that is mounted upside down are reversed.

    Args:
        path: a folder of rosbag2, or a .mcap, .db3 or .bag file.
        scan_topic: topic of the scans (default: the LaserScan topic with the most messages).

    Raises:
        InputError: the extra `bags` is not installed.
        FileError: the bag cannot be read, or has no scans or no odometry.
    """
    missing = lack("a ROS bag", "bags")
    if missing is not None:
        raise InputError(missing)
    try:
        bag = read_bag(path, {SCAN, ODOMETRY, TRANSFORMS, OLD_TRANSFORMS})
    except BagError as error:
        raise FileError([Finding(str(path), 0, 0, str(error))]) from None
    notes = [*bag.notes, *_unreadable(bag)]
    scans = _on_one_clock(path, _scans(path, bag, scan_topic), notes)
    transforms = _transforms(bag)
    times, track, base, source = _odometry(path, bag, transforms, notes)
    frame = str(scans[0].content.header.frame_id).lstrip("/")
    mount, is_flipped, words = _mount(transforms, base, frame)
    notes += [f"odometry: {source}", words]
    return _log(path, scans, (times, track), (mount, is_flipped), notes)


def _refused(path: Path, words: str) -> FileError:
    return FileError([Finding(str(path), 0, 0, words)])


def _unreadable(bag: Bag) -> Iterator[str]:
    for topic, count in bag.unreadable.items():
        yield f"{topic}: {count} messages can't be read; they are skipped"


def _scans(path: Path, bag: Bag, scan_topic: str | None) -> list[BagMessage]:
    topics = [topic for topic, kind in bag.topics.items() if kind == SCAN]
    if scan_topic is not None and scan_topic not in topics:
        wrong = f"no scans on the topic {scan_topic!r}{suggest(scan_topic, topics)}"
        raise _refused(path, wrong if topics else f"no {SCAN} in it; it has: {listed(sorted(bag.topics))}")
    counts = Counter(message.topic for message in bag.messages if message.kind == SCAN)
    if not counts:
        raise _refused(path, f"no {SCAN} in it that can be read; it has: {listed(sorted(bag.topics))}")
    chosen = scan_topic or counts.most_common(1)[0][0]
    found = [message for message in bag.messages if message.topic == chosen]
    if len(found) < 2:
        raise _refused(path, f"{chosen}: {len(found)} scans; needed: at least two")
    return found


def _stamp(header: Any) -> float:
    return float(header.stamp.sec + 1e-9 * header.stamp.nanosec)


def _planar(place: Any, turned: Any) -> Pose2:
    return Pose2(float(place.x), float(place.y), heading_of(turned.x, turned.y, turned.z, turned.w))


def _is_flipped(turned: Any) -> bool:
    """Return whether the z axis points down."""
    return bool(turned.w**2 + turned.z**2 < turned.x**2 + turned.y**2)


def _transforms(bag: Bag) -> dict[str, list[tuple[float, str, Pose2, bool]]]:
    """Return for each frame in tf, by name, its transforms: time in [s], parent, planar pose, whether it is
    upside down.
    """
    found = dict[str, list[tuple[float, str, Pose2, bool]]]()
    for message in bag.messages:
        if message.kind not in (TRANSFORMS, OLD_TRANSFORMS):
            continue
        for transform in message.content.transforms:
            pose = _planar(transform.transform.translation, transform.transform.rotation)
            if not all(map(math.isfinite, pose)):
                continue
            row = _stamp(transform.header), str(transform.header.frame_id).lstrip("/"), pose
            name = str(transform.child_frame_id).lstrip("/")
            found.setdefault(name, []).append((*row, _is_flipped(transform.transform.rotation)))
    return found


def _on_one_clock(path: Path, messages: list[BagMessage], notes: list[str]) -> list[BagMessage]:
    """Return the messages of a topic whose stamps can be used, and add notes about the others.

    Raises:
        FileError: the stamps jump for good, as in a bag that was recorded over a restart of the simulation or
            of a bag that is played in a loop, or most of them are zero.
    """
    stamps = np.array([_stamp(message.content.header) for message in messages])
    if (np.diff(stamps) >= 0.0).all():
        return messages
    received = np.array([message.received for message in messages])
    report = check_stamps(messages[0].topic, stamps, received)
    if report.unusable:
        raise _refused(path, f"{report.unusable}; allowed: stamps of one clock that rises; cut the bag there")
    notes += report.notes
    return [messages[row] for row in np.flatnonzero(report.used)]


def _odometry(
    path: Path, bag: Bag, transforms: dict[str, list[Any]], notes: list[str]
) -> tuple[FloatArray, FloatArray, str, str]:
    """Return the odometry in a bag.

    Args:
        path: path of the bag, named in errors.
        bag: its messages.
        transforms: transforms of each frame in tf.
        notes: receives messages about tolerable faults of the stamps.

    Returns:
        Times (n,) in [s]; odom_T_base (n, 3), x, y in [m] and heading in [rad]; the base's frame; and their
            source in words.

    Raises:
        FileError: the bag has no odometry, or none of its poses can be used.
    """
    topic = next((topic for topic, kind in bag.topics.items() if kind == ODOMETRY), None)
    messages = [message for message in bag.messages if message.topic == topic]
    if len(messages) > 1:
        messages = _on_one_clock(path, messages, notes)
        poses = [_planar(m.content.pose.pose.position, m.content.pose.pose.orientation) for m in messages]
        times = [_stamp(message.content.header) for message in messages]
        base = str(messages[0].content.child_frame_id).lstrip("/") or "base_link"
        return _finite(path, np.array(times), np.array(poses), base, f"the topic {topic}")
    for frame, rows in transforms.items():
        if rows[0][1] in ODOM_FRAMES and len(rows) > 1:
            times, poses = [row[0] for row in rows], [row[2] for row in rows]
            words = f"tf, from {rows[0][1]} to {frame}"
            return _finite(path, np.array(times), np.array(poses), frame, words)
    wrong = f"no odometry in it; needed: {ODOMETRY}, or tf from {' or '.join(ODOM_FRAMES)} to the base"
    raise _refused(path, wrong)


def _finite(
    path: Path, times: FloatArray, poses: FloatArray, base: str, words: str
) -> tuple[FloatArray, FloatArray, str, str]:
    good = np.isfinite(poses).all(axis=1) & (np.abs(poses) < MAX_COORDINATE_M).all(axis=1)
    if not good.any():
        wrong = f"{words}: none of {len(poses)} poses is finite and within {MAX_COORDINATE_M / 1e3:g} km"
        raise _refused(path, f"{wrong} of the origin; needed: odometry relative to a place near the drive")
    return times[good], poses[good], base, words


def _mount(transforms: dict[str, list[Any]], base: str, frame: str) -> tuple[Pose2, bool, str]:
    """Return base_T_sensor, whether the lidar is upside down, and a note on the source of the mounting."""
    pose, is_flipped, seen = Pose2(0.0, 0.0, 0.0), False, {frame}
    at = frame
    while at != base:
        rows = transforms.get(at)
        if rows is None or rows[0][1] in seen:
            words = (
                f"tf has no way from {base} to {frame}: the lidar is taken to be in the middle of the base"
            )
            return Pose2(0.0, 0.0, 0.0), False, words
        _, parent, step, flips = rows[0]
        moved = Pose2(pose.x, -pose.y, -pose.theta) if flips else pose
        pose, is_flipped = step.compose(moved), is_flipped != flips
        seen.add(parent)
        at = parent
    words = f"lidar at x {pose.x:.2f} m, y {pose.y:.2f} m, {math.degrees(pose.theta):.1f} deg on {base}"
    return pose, is_flipped, words + (", upside down" if is_flipped else "")


def _log(
    path: Path,
    scans: list[BagMessage],
    odometry: tuple[FloatArray, FloatArray],
    mounted: tuple[Pose2, bool],
    notes: list[str],
) -> ScanLog:
    mount, is_flipped = mounted
    topic, messages = scans[0].topic, [message.content for message in scans]
    kept = [message for message in messages if has_usable_angles(message)]
    if len(kept) < 2:
        allowed = "at least two beams, each at another angle in [rad], within one turn"
        raise _refused(path, f"{topic}: {angles_in_words(messages[0])}; allowed: {allowed}")
    if len(kept) < len(scans):
        notes.append(f"{len(scans) - len(kept)} scans have no beams or no usable angles; they are skipped")
    notes += [f"{topic}: {words}" for words in angle_notes(kept)]
    times = np.array([_stamp(message.header) for message in kept])
    poses, near = poses_at(times, *odometry)
    rows = np.flatnonzero(near)[np.argsort(times[near], kind="stable")]
    rows = rows[np.concatenate([[True], np.diff(times[rows]) > 0.0])] if len(rows) else rows
    if len(rows) < len(times):
        notes.append(f"{len(times) - len(rows)} scans have no odometry within a second, or a repeated time")
    if len(rows) < 2:
        raise _refused(path, "no two scans with odometry near their times; needed: one clock for both")
    angles, ranges = scan_arrays([kept[row] for row in rows], is_flipped)
    if not np.isfinite(ranges).any():
        raise _refused(path, "no scan has a reading; needed: ranges between range_min and range_max")
    reach = float(kept[rows[0]].range_max)
    return ScanLog(times[rows] - times[rows[0]], poses[rows], angles, ranges, mount, reach, tuple(notes))
