"""Scans of ROS bags: odometry from a topic, and where the lidar is on the base, upright or upside down."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from handcart.evaluation.mapping.bag_scans import read_bag_scans
from handcart.files.errors import FileError
from handcart.robotics.geometry.pose2 import Pose2

pytest.importorskip("rosbags", reason="bags are read by the extra `bags`")

ANGLES = np.linspace(-1.0, 1.5, 6)
RANGES = np.array([[1.0, 2.0, 3.0, 4.0, 5.0, 6.0], [1.5, 2.5, 3.5, math.inf, 5.5, math.nan]])
MOUNT = (0.3, -0.2, 0.4)
ON_PLATE = (0.05, 0.02, 0.1)
"""Pose of the lidar on a plate, which is at MOUNT on the base, and may be upside down."""
ODOMETRY = ((0.0, 0.0, 0.0), (0.5, 0.25, 0.1), (1.0, 0.5, 0.2))


def turned(heading: float, is_flipped: bool) -> tuple[float, float, float, float]:
    """Return the quaternion of a heading in [rad], after half a turn about x if it is upside down."""
    z, w = math.sin(heading / 2), math.cos(heading / 2)
    return (w, z, 0.0, 0.0) if is_flipped else (0.0, 0.0, z, w)


Beams = tuple[float, float, float, Any]
"""angle_min, angle_max, angle_increment and ranges of a scan."""


def write_bag(
    path: Path,
    is_flipped: bool,
    east: float = 0.0,
    lengths: tuple[float, ...] = (1.0, 1.0, 1.0),
    scans: tuple[Beams, ...] | None = None,
    clock: Callable[[float], float] = float,
) -> None:
    """Write two scans, at 0.5 s and 1.0 s, odometry at 0, 1 and 2 s, `east` of its origin in [m], and the
    mounting on tf_static; `lengths` are those of the odometry's quaternions. More `scans` follow each 0.1 s,
    and `clock` gives the stamp of a time.
    """
    from rosbags.rosbag2 import Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    kinds: Any = store.types

    def header(at: float, frame: str) -> Any:
        time = clock(at)
        stamp = kinds["builtin_interfaces/msg/Time"](int(time), round((time % 1) * 1e9))
        return kinds["std_msgs/msg/Header"](stamp, frame)

    def pose(x: float, y: float, quaternion: tuple[float, ...]) -> Any:
        point = kinds["geometry_msgs/msg/Point"](x, y, 0.0)
        return kinds["geometry_msgs/msg/Pose"](point, kinds["geometry_msgs/msg/Quaternion"](*quaternion))

    names = "sensor_msgs/msg/LaserScan", "nav_msgs/msg/Odometry", "tf2_msgs/msg/TFMessage"
    with Writer(path, version=9) as writer:
        topics = [
            writer.add_connection(topic, name, typestore=store)
            for topic, name in zip(("/scan", "/odom", "/tf_static"), names, strict=True)
        ]

        def write(number: int, time: float, content: Any) -> None:
            writer.write(topics[number], int(time * 1e9), store.serialize_cdr(content, names[number]))

        links = [("base", "plate", MOUNT, is_flipped), ("plate", "laser", ON_PLATE, False)]
        for parent, child, (x, y, heading), flips in links:
            vector = kinds["geometry_msgs/msg/Vector3"](x, y, 0.2)
            quaternion = kinds["geometry_msgs/msg/Quaternion"](*turned(heading, flips))
            moved = kinds["geometry_msgs/msg/Transform"](vector, quaternion)
            link = kinds["geometry_msgs/msg/TransformStamped"](header(0.0, parent), child, moved)
            write(2, 0.0, kinds[names[2]]([link]))
        zero = kinds["geometry_msgs/msg/Vector3"](0.0, 0.0, 0.0)
        still = kinds["geometry_msgs/msg/TwistWithCovariance"](
            kinds["geometry_msgs/msg/Twist"](zero, zero), np.zeros(36)
        )
        for when, (ox, oy, turn) in enumerate(ODOMETRY):
            there = kinds["geometry_msgs/msg/PoseWithCovariance"](
                pose(ox + east, oy, tuple(lengths[when] * part for part in turned(turn, False))), np.zeros(36)
            )
            write(1, float(when), kinds[names[1]](header(float(when), "odom"), "base", there, still))
        # Seen from above, the beams of a lidar that is upside down run clockwise.
        angles, ranges = (-ANGLES[::-1], RANGES[:, ::-1]) if is_flipped else (ANGLES, RANGES)
        ends = float(angles[0]), float(angles[-1]), float(angles[1] - angles[0])
        all_scans = scans or tuple((*ends, row) for row in ranges)
        times = (0.5, 1.0, *(1.0 + 0.1 * k for k in range(1, len(all_scans) - 1)))
        for time, beams in zip(times, all_scans, strict=True):
            limits, row = (*beams[:3], 0.0, 0.1, 0.05, 12.0), np.asarray(beams[3])
            content = header(time, "laser"), *limits, row.astype(np.float32), np.zeros(0, np.float32)
            write(0, time, kinds[names[0]](*content))


@pytest.mark.parametrize("is_flipped", [False, True])
def test_points_in_the_base_frame_are_those_of_the_world(tmp_path: Path, is_flipped: bool) -> None:
    """Upright and upside down, the same walls lie at the same places."""
    write_bag(tmp_path / "bag", is_flipped)
    log = read_bag_scans(tmp_path / "bag")
    rays = np.column_stack([np.cos(ANGLES), np.sin(ANGLES)])
    x, y, heading = ON_PLATE
    inner = Pose2(x, -y, -heading) if is_flipped else Pose2(x, y, heading)
    expected = Pose2(*MOUNT).compose(inner).apply(RANGES[0][:, None] * rays)
    found_rays = np.column_stack([np.cos(log.angles), np.sin(log.angles)])
    assert log.mount.apply(log.ranges[0][:, None] * found_rays) == pytest.approx(expected, abs=1e-6)
    assert log.ranges[1] == pytest.approx(RANGES[1], nan_ok=True)
    assert (np.diff(log.angles) > 0.0).all()
    assert any("upside down" in note for note in log.notes) is is_flipped


def test_odometry_of_a_topic_is_read_at_the_scans_times(tmp_path: Path) -> None:
    write_bag(tmp_path / "bag", False)
    log = read_bag_scans(tmp_path / "bag")
    assert log.times.tolist() == [0.0, 0.5]
    assert log.odometry == pytest.approx(np.array([[0.25, 0.125, 0.05], [0.5, 0.25, 0.1]]))
    assert "odometry: the topic /odom" in log.notes


@pytest.mark.parametrize("east", [math.nan, 5.2e6])
def test_odometry_without_a_usable_pose_is_refused(tmp_path: Path, east: float) -> None:
    """As of an estimator that never began, and of one in coordinates of UTM."""
    write_bag(tmp_path / "bag", False, east)
    with pytest.raises(FileError, match=r"topic /odom: none of 3 poses is finite and within 1000 km"):
        read_bag_scans(tmp_path / "bag")


def test_quaternions_of_any_length_are_turns_and_zeros_are_none(tmp_path: Path) -> None:
    """An odometry that rounds its quaternions, or whose first message was not filled in."""
    write_bag(tmp_path / "even", False)
    expected = read_bag_scans(tmp_path / "even")
    write_bag(tmp_path / "uneven", False, lengths=(1.02, 0.5, 3.0))
    assert read_bag_scans(tmp_path / "uneven").odometry == pytest.approx(expected.odometry, abs=1e-9)
    write_bag(tmp_path / "empty", False, lengths=(0.0, 1.0, 1.0))
    assert read_bag_scans(tmp_path / "empty").odometry[-1] == pytest.approx(expected.odometry[-1])
    assert read_bag_scans(tmp_path / "empty").odometry[0] == pytest.approx(ODOMETRY[1])


def test_each_scan_is_read_by_its_own_angles(tmp_path: Path) -> None:
    """As of drivers that spread whatever a turn had over the circle, from an angle of its own."""
    scans = (
        (-3.0, 3.0, 1.0, [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]),
        (-2.9, 3.1, 0.5, [*np.linspace(1.0, 7.0, 13)]),
    )
    write_bag(tmp_path / "bag", False, scans=scans)
    log = read_bag_scans(tmp_path / "bag")
    for row, (first, _, step, ranges) in enumerate(scans):
        known = np.isfinite(log.ranges[row])
        assert log.ranges[row][known] == pytest.approx(ranges)
        assert log.angles[row][known] == pytest.approx(first + step * np.arange(len(ranges)))
    assert "/scan: scans of 7 to 13 beams; each is read by its own angles" in log.notes


@pytest.mark.parametrize(
    ("ends", "words"),
    [
        ((-3.0, 3.0, -1.0), "2 scans have an angle_increment that leads away from angle_max"),
        ((-3.0, 3.0, 0.5), "the last beam is 6 beams short of angle_max; angle_increment is taken as it is"),
        ((-3.0, 0.0, 1.0), "the last beam is 3 beams past angle_max"),
        ((-3.0, 4.0, 1.0), ""),
        ((0.0, 0.0, 1.0), ""),
        ((3.0, -3.0, -1.0), ""),
    ],
)
def test_angles_that_contradict_each_other_are_reported(
    tmp_path: Path, ends: tuple[float, float, float], words: str
) -> None:
    beams = (*ends, np.linspace(1.0, 2.0, 7))
    write_bag(tmp_path / "bag", False, scans=(beams, beams))
    notes = [note for note in read_bag_scans(tmp_path / "bag").notes if note.startswith("/scan: ")]
    assert [words in note for note in notes] == ([True] if words else [])


@pytest.mark.parametrize("step", [0.0, 30.0, math.nan])
def test_scans_without_usable_angles_are_refused(tmp_path: Path, step: float) -> None:
    """An increment that was not filled in, one in degrees."""
    beams = (-3.0, 3.0, step, np.linspace(1.0, 2.0, 7))
    write_bag(tmp_path / "bag", False, scans=(beams, beams))
    with pytest.raises(FileError, match=r"/scan: 7 beams from -3 rad, angle_increment .* within one turn"):
        read_bag_scans(tmp_path / "bag")


def test_stamps_that_begin_again_are_refused(tmp_path: Path) -> None:
    """As in a bag that was recorded while a simulation was restarted, or another bag played in a loop."""
    beams = (-1.0, 1.5, 0.5, RANGES[0])
    write_bag(tmp_path / "bag", False, scans=(beams,) * 14, clock=lambda time: time % 1.55)
    with pytest.raises(
        FileError, match=r"/scan: stamps jump by -1\.6 s after 1\.\d s; .* one clock that rises"
    ):
        read_bag_scans(tmp_path / "bag")
