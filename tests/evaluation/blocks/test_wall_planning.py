"""Planning of stops, order and a task from a drawing."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from handcart.backends.loading.robot_loading import load_robot
from handcart.evaluation.blocks.swept_zones import swept_zones
from handcart.evaluation.blocks.wall_planning import plan_wall
from handcart.files.errors import FileError
from handcart.primitives.knowledge.place import load_map
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.kinematics.shapes import Box
from handcart.robotics.manipulation.placement.standing_places import stands_clear
from tests.primitives.blocks.drawings import drawing_file, load_drawing

CHART = Path(__file__).parents[3] / "tasks" / "build_wall" / "map.yaml"
BLOCK = (0.025, 0.08, 0.04)


@pytest.mark.slow
def test_a_wall_too_high_for_the_arm_names_the_block_and_why(tmp_path: Path) -> None:
    rows = "  - {x_m: 4.1, y_m: 1.82, height_m: 1.6, heading_deg: -90, along_mm: [0]}\n"
    loaded = load_drawing(drawing_file(tmp_path, rows, height=1.6))
    with pytest.raises(FileError, match=r"drawing.yaml:17:\d+: block 1 of row 1 is out of the arm's reach"):
        plan_wall(loaded, load_robot("toyama/h1"), load_map(CHART)[0])


@pytest.mark.slow
def test_unreachable_wall_names_the_block_and_the_cause(tmp_path: Path) -> None:
    grid = load_map(CHART)[0]
    columns = grid.to_point(
        np.column_stack([np.zeros(grid.occupied.shape[1], int), np.arange(grid.occupied.shape[1])])
    )
    beyond = grid._replace(occupied=grid.occupied | (columns[:, 0] > 3.3)[None])
    with pytest.raises(FileError, match="is reached only from where the base can't stand, or doesn't get to"):
        plan_wall(load_drawing(drawing_file(tmp_path)), load_robot("toyama/h1"), beyond)


@pytest.mark.parametrize(("size", "height"), [(BLOCK, 0.42), ((0.76, 0.66, 0.04), 0.38)])
def test_out_of_its_zone_the_robot_turns_freely(size: tuple[float, float, float], height: float) -> None:
    spec = load_robot("toyama/h1")
    pose = Pose2(0.0, 0.0, 0.4).lift(height)
    thing = Box(pose, size)
    x, y, yaw, length, width = swept_zones(spec, [thing])[0]
    bodies = spec.arm_model().link_shapes(np.array(spec.posture("home")))
    away, zone = spec.footprint_radius_m + 0.01, Pose2(x, y, yaw)
    ways = np.pi / 4 * np.arange(8)
    offsets = np.column_stack((np.cos(ways), np.sin(ways)))
    corners = np.where(np.abs(offsets) < 0.1, 0.0, np.sign(offsets)) * (length / 2, width / 2)
    spots = np.repeat(zone.apply(corners + away * offsets), 24, axis=0)
    turns = np.tile(np.linspace(-np.pi, np.pi, 24, endpoint=False), len(ways))
    assert stands_clear(np.column_stack((spots, turns)), bodies, [thing]).all()


@pytest.mark.slow
def test_stops_are_clear_of_the_blocks_and_trips_carry_what_fits(tmp_path: Path) -> None:
    loaded = load_drawing(drawing_file(tmp_path))
    plan = plan_wall(loaded, load_robot("toyama/h1"), load_map(CHART)[0])
    assert [block.row for block in plan.blocks] == [1, 1, 0]
    assert [list(trip.numbers) for trip in plan.trips] == [[1], [2], [3]]
    for stop in (*plan.fetching, *plan.laying):
        assert stop.clearance >= load_robot("toyama/h1").footprint_radius_m
    assert plan.laying[0].landmark == "wall"
