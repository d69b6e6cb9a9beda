"""`handcart map` on lidars whose beams or mounting the log describes wrongly."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.driving.worlds.box_ranges import box_ranges
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.mapping.scan_log import ScanLog

from .test_map_log import written

WALLS = [
    (3.0, -1.05, 0.0, 8.0, 0.1),
    (3.0, 4.05, 0.0, 8.0, 0.1),
    (-1.05, 1.5, 0.0, 0.1, 5.2),
    (7.05, 1.5, 0.0, 0.1, 5.2),
    (2.0, 2.5, 0.3, 0.5, 0.9),
    (5.5, 0.0, 0.0, 0.8, 0.4),
]


def bend(mirrored: bool = False, backward: bool = False, scale: float = 1.0) -> ScanLog:
    """Return the log of a drive around a bend, with a lidar that the log describes wrongly."""
    angles, share = np.radians(np.arange(-180.0, 180.0, 3.0)), np.linspace(0.0, 1.0, 30)
    straight = [Pose2(2.0 * s, 0.0, 0.0) for s in share]
    turn = [Pose2(2.0 + 1.5 * math.sin(2 * s), 1.5 - 1.5 * math.cos(2 * s), 2 * s) for s in share[1:]]
    ranges = np.array([box_ranges(WALLS, pose, angles) for pose in (*straight, *turn)])
    ranges += np.random.default_rng(1).normal(0.0, 0.005, ranges.shape)
    odometry = np.array([*straight, *turn])
    if mirrored:
        ranges = np.roll(ranges[:, ::-1], 1, axis=1)
    if backward:
        ranges = np.roll(ranges, 60, axis=1)
    odometry[:, :2] *= scale
    times = 0.5 * np.arange(len(odometry), dtype=np.float64)
    return ScanLog(times, odometry, angles, ranges, Pose2(0.0, 0.0, 0.0), 20.0)


@pytest.mark.parametrize(
    ("fault", "words"),
    [
        ({}, ""),
        ({"mirrored": True}, "the scans turn in the opposite direction of the odometry (-1.0"),
        ({"backward": True}, "the scans move 180 deg to the left of the odometry's direction"),
        ({"scale": 2.0}, "the scans move 0.5"),
    ],
    ids=["right", "mirrored", "backward", "scale"],
)
def test_lidar_that_contradicts_the_odometry_is_reported(
    tmp_path: Path, handcart: Callable[..., Any], fault: dict[str, Any], words: str
) -> None:
    log = written(bend(**fault), tmp_path / "drive.csv")
    said = handcart("map", log, "-o", tmp_path / "map")
    summary = json.loads((tmp_path / "map" / "summary.json").read_text())
    assert bool(words) is ("the scans" in said.out)
    assert words.replace("left", "right") in said.out.replace("left", "right")
    assert [words[:12] in note for note in summary["notes"]] == ([True] if words else [])
    if not words:
        assert summary["odometry"]["turn_ratio"] == pytest.approx(1.0, abs=0.05)
