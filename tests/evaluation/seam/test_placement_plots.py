"""The pictures are drawn; their content is judged by people."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from handcart.evaluation.seam.placement_plots import (
    DividedPath,
    draw_divisions,
)
from handcart.evaluation.seam.tracking_plot import draw_tracking_errors
from handcart.robotics.manipulation.arms.pitch_arm import PitchArm
from handcart.robotics.manipulation.paths.tool_path import ToolPath, tool_path
from handcart.robotics.manipulation.placement.placement_division import Division, PathSegment


@pytest.fixture
def path() -> ToolPath:
    poses = np.tile(np.eye(4), (61, 1, 1))
    poses[:, 0, 3], poses[:, 2, 3] = np.linspace(0.0, 2.4, 61), 0.9
    poses[:, :3, :3] = [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]
    return tool_path(poses)


@pytest.fixture
def panel() -> DividedPath:
    bases = np.array([[0.5, -1.2, 1.5], [1.8, -1.2, 1.5]])
    return DividedPath("by hand", bases, Division((PathSegment(0, 0, 30), PathSegment(1, 30, 60)), 2.0))


def _is_a_picture(file: Path) -> bool:
    image = cv2.imread(str(file))
    return image is not None and float(image.std()) > 5.0


def test_divisions_are_drawn(tmp_path: Path, path: ToolPath, panel: DividedPath) -> None:
    draw_divisions(path, [panel], tmp_path / "4.png", PitchArm())
    draw_divisions(path, [panel], tmp_path / "any_arm.png")
    assert all(_is_a_picture(tmp_path / name) for name in ("4.png", "any_arm.png"))


def test_tracking_errors_are_drawn(tmp_path: Path) -> None:
    times = np.linspace(0.0, 10.0, 200)
    errors = 1e-3 * np.abs(np.sin(times))
    draw_tracking_errors([("standing", times, errors), ("moving", times, 25 * errors)], tmp_path / "5.png")
    assert _is_a_picture(tmp_path / "5.png")
