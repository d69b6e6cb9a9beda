"""CARMEN logs: both kinds of scans, optional fields of a line, and malformed lines."""

from __future__ import annotations

import gzip
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from handcart.evaluation.mapping.carmen_scans import read_carmen
from handcart.files.errors import FileError
from handcart.robotics.geometry.pose2 import Pose2

RANGES = [1.25, 2.5, 81.83, 3.75, 0.5]


def flaser(time: float, ranges: list[float], odometry: tuple[float, float, float]) -> str:
    """Return a line whose first pose is a corrected one, which must not be read."""
    cells = [len(ranges), *ranges, 9.0, 9.0, 9.0, *odometry, time]
    return " ".join(["FLASER", *map(str, cells), "host", str(time)])


def robot_laser(time: float, ranges: list[float], laser: Pose2, robot: Pose2) -> str:
    head = [0, -0.5, 1.0, 0.25, 20.0, 0.01, 0, len(ranges)]
    cells = [*head, *ranges, 2, 7, 8, *laser, *robot, 0, 0, 0, 0, 0, time]
    return " ".join(["ROBOTLASER1", *map(str, cells), "host", str(time)])


def odom(time: float, pose: tuple[float, float, float]) -> str:
    return " ".join(["ODOM", *map(str, [*pose, 0.1, 0.0, 0.0, time]), "host", str(time)])


def written(path: Path, *lines: str) -> Path:
    path.write_text("\n".join(["# a comment", "PARAM x y", *lines]) + "\n", encoding="utf-8")
    return path


def test_flaser_lines_have_their_own_odometry(tmp_path: Path) -> None:
    ranges = np.linspace(1.0, 2.0, 180).tolist()
    lines = [flaser(time, ranges, (time, 0.5, -0.25)) for time in (1.0, 2.0)]
    log = read_carmen(written(tmp_path / "a.log", *lines))
    assert log.times.tolist() == [1.0, 2.0]
    assert log.odometry.tolist() == [[1.0, 0.5, -0.25], [2.0, 0.5, -0.25]]
    assert np.allclose(log.ranges, [ranges, ranges])
    assert (math.degrees(log.angles[0]), math.degrees(log.angles[-1])) == pytest.approx((-89.5, 89.5))
    assert log.mount == Pose2(0.0, 0.0, 0.0)


def test_odom_lines_go_before_what_a_scan_states(tmp_path: Path) -> None:
    lines = [odom(0.5, (0.0, 0.0, 3.0)), odom(1.5, (2.0, 4.0, -3.0))]
    lines += [flaser(time, RANGES, (9.0, 9.0, 9.0)) for time in (1.0, 1.5, 9.0)]
    log = read_carmen(written(tmp_path / "a.log", *lines))
    assert log.odometry[:, :2].tolist() == [[1.0, 2.0], [2.0, 4.0]]
    assert abs(log.odometry[0, 2]) == pytest.approx(math.pi)  # the short way round
    assert log.notes == ("1 scans have no odometry within a second; they are skipped",)
    assert np.isnan(log.ranges[0, 2])


def test_robotlaser_lines_state_view_and_mounting(tmp_path: Path) -> None:
    robot = Pose2(1.0, 2.0, math.pi / 2)
    laser = robot.compose(Pose2(0.3, -0.1, 0.2))
    lines = [robot_laser(time, RANGES, laser, robot) for time in (1.0, 2.0)]
    log = read_carmen(written(tmp_path / "a.log", *lines))
    assert log.angles == pytest.approx([-0.5, -0.25, 0.0, 0.25, 0.5])
    assert log.odometry[0] == pytest.approx(robot)
    assert log.mount == pytest.approx((0.3, -0.1, 0.2))
    assert log.reach == 20.0


def test_packed_log_is_read_the_same(tmp_path: Path) -> None:
    lines = [flaser(time, RANGES, (time, 0.0, 0.0)) for time in (1.0, 2.0)]
    plain = written(tmp_path / "a.log", *lines)
    packed = tmp_path / "a.log.gz"
    packed.write_bytes(gzip.compress(plain.read_bytes()))
    one, other = read_carmen(plain), read_carmen(packed)
    assert np.array_equal(one.ranges, other.ranges, equal_nan=True)
    assert np.array_equal(one.odometry, other.odometry)


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("FLASER", "no number of readings"),
        ("FLASER 1e9 1", "no number of readings; allowed: 2 to 10000"),
        ("FLASER 3 1 2 3", "5 words; needed: 14 for 3 readings"),
        ("FLASER 2 1 x 0 0 0 0 0 0 1.0 h 1.0", "a word is no number"),
        ("ODOM 0 0 0", "a word is missing or no number"),
        ("ROBOTLASER1 0 -1.5 3.1", "no number of readings"),
    ],
)
def test_bad_line_is_refused_at_its_place(tmp_path: Path, line: str, said: str) -> None:
    path = written(tmp_path / "a.log", flaser(1.0, RANGES, (0.0, 0.0, 0.0)), line)
    with pytest.raises(FileError) as error:
        read_carmen(path)
    assert f"{path}:4:1: {line.split()[0]}: " in str(error.value)
    assert said in str(error.value)


WORD = st.one_of(
    st.sampled_from(["FLASER", "ODOM", "ROBOTLASER1", "2", "-1", "1e308", "nan", "inf", "x", "0.5", "180"]),
    st.floats(allow_nan=True).map(str),
)


@given(lines=st.lists(st.lists(WORD, max_size=30).map(" ".join), max_size=6))
def test_any_words_are_read_or_refused(tmp_path_factory: pytest.TempPathFactory, lines: list[str]) -> None:
    """Never another error: a log comes from anybody."""
    path = tmp_path_factory.mktemp("log") / "a.log"
    path.write_text("\n".join(lines), encoding="utf-8")
    try:
        log = read_carmen(path)
    except FileError:
        return
    assert np.isfinite(log.odometry).all()
    assert (np.diff(log.times) >= 0.0).all()
