"""Across a hall that is wider than the lidar sees: wheels carry the pose on where the map shows nothing."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from handcart.backends.loading.robot_loading import load_robot
from handcart.evaluation.trials.rig import Rig, RigFiles, build_rig
from handcart.primitives.driving.move_to import MoveTo
from handcart.primitives.outcomes.outcome import Fail, Success

SIDE_M, CELL_M, CRATE_M = 14.0, 0.05, 0.6
CRATES = ((1.0, 3.5), (3.2, 1.0), (13.0, 11.0), (10.5, 13.0))
PLACES = """\
format: handcart-places/1
places:
  home: {x_m: 2.2, y_m: 2.2, heading_deg: 45}
  middle: {x_m: 7, y_m: 7, heading_deg: 45}
  far: {x_m: 11.8, y_m: 11.8, heading_deg: 45}
"""
WORLD = "format: handcart-world/1\nmap: map.yaml\nstart: {x_m: 2.2, y_m: 2.2, heading_deg: 45}\n"


@pytest.fixture
def hall(tmp_path: Path) -> Callable[..., Rig]:
    """Builds a rig between crates in a corner of a hall, with a lidar of that reach."""

    def make(reach: float) -> Rig:
        solid = np.zeros((round(SIDE_M / CELL_M),) * 2, np.bool_)
        solid[:2] = solid[-2:] = solid[:, :2] = solid[:, -2:] = True
        for x, y in CRATES:
            low, high = ([round((v + side) / CELL_M) for v in (x, y)] for side in (-CRATE_M / 2, CRATE_M / 2))
            solid[low[1] : high[1], low[0] : high[0]] = True
        Image.fromarray(np.where(solid[::-1], 0, 254).astype(np.uint8)).save(tmp_path / "map.png")
        (tmp_path / "map.yaml").write_text(
            f"image: map.png\nresolution: {CELL_M}\norigin: [0, 0, 0]\nnegate: 0\n"
            "occupied_thresh: 0.65\nfree_thresh: 0.196\n"
        )
        (tmp_path / "places.yaml").write_text(PLACES)
        (tmp_path / "world.yaml").write_text(WORLD)
        robot = tmp_path / "robot"
        robot.mkdir()
        for path in load_robot("cart").folder.iterdir():
            if path.is_file():
                (robot / path.name).write_bytes(path.read_bytes())
        text = (robot / "robot.yaml").read_text()
        lines = [f"  reach_m: {reach}" if "reach_m:" in line else line for line in text.splitlines()]
        (robot / "robot.yaml").write_text("\n".join(lines) + "\n")
        files = RigFiles(tmp_path / "world.yaml", tmp_path / "map.yaml", tmp_path / "places.yaml", {})
        return build_rig(files, robot=str(robot / "robot.yaml"), seed=1)

    return make


@pytest.mark.slow
def test_hall_wider_than_the_lidar_sees_is_crossed(hall: Callable[..., Rig]) -> None:
    with hall(reach=5.0) as rig:
        least, look = [360], rig.robot.range_sensor.scan
        step = rig.robot.step

        def and_count(paused: bool = False) -> None:
            step(paused)
            least[0] = min(least[0], len(look().points()))

        rig.robot.step = and_count  # type: ignore[method-assign]
        outcome = rig.do(MoveTo(place="far"))
        truth = rig.backend.ground_truth()
        goal = rig.model.places["far"].pose
    assert isinstance(outcome, Success), outcome
    assert least[0] == 0
    assert truth is not None
    assert truth.base.distance(goal) < 0.04


@pytest.mark.slow
def test_place_where_nothing_is_seen_is_not_determined(hall: Callable[..., Rig]) -> None:
    with hall(reach=3.0) as rig:
        outcome = rig.do(MoveTo(place="middle"))
        truth = rig.backend.ground_truth()
        start = rig.model.places["home"].pose
    assert isinstance(outcome, Fail), outcome
    assert outcome.cause.name == "undetermined"
    assert truth is not None
    assert truth.base.distance(start) < 0.045
