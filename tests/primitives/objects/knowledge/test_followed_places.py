"""Computed places of the base, and the map, follow a surface that was measured elsewhere."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from handcart.evaluation.trials.rig import Rig
from handcart.primitives.driving.move_to import MoveTo
from handcart.primitives.knowledge.place import Place
from handcart.primitives.objects.knowledge.objects import Objects, SurfacePose
from handcart.primitives.objects.knowledge.surface_places import followed_place
from handcart.primitives.outcomes.outcome import Success
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.maps.grid_map import GridMap

from ..fetching import changed, rig_with, scene_of

COVARIANCE = ((4e-6, 0.0, 0.0), (0.0, 4e-6, 0.0), (0.0, 0.0, 1e-5))
NEARER_A = Pose2(2.03, 3.72, math.radians(3.0))  # by 80 mm towards the base
HOME = Place(x_m=1.0, y_m=1.0, heading_deg=0.0)


def followed(rig: Rig, now: Pose2, grid: GridMap | None = None, name: str = "table_a") -> Place:
    objects = rig.model.of(Objects)
    surface = objects.objects.surfaces[name].moved_to(now)
    drawn = rig.model.map if grid is None else grid
    before = objects.objects.surfaces[name]
    return followed_place(rig.robot.spec, drawn, before, surface, objects.stands[name], [HOME])


def test_place_moves_with_its_surface() -> None:
    rig = rig_with()
    objects = rig.model.of(Objects)
    objects.surface_poses = (SurfacePose("table_a", NEARER_A, COVARIANCE),)
    place = followed(rig, NEARER_A, rig.model.redraw_moved())
    before, stand = objects.objects.surfaces["table_a"].floor, objects.stands["table_a"].pose
    expected = NEARER_A.compose(stand.relative_to(before))
    assert place.pose.turn(expected) < 1e-9
    off = place.pose.relative_to(expected)
    assert -0.061 < off.x <= 0.0 and abs(off.y) < 1e-9  # straight back, where cells are coarse


def test_place_stays_where_a_surface_is_as_its_file_says() -> None:
    rig = rig_with()
    stand = rig.model.of(Objects).stands["table_a"]
    assert followed(rig, Pose2(2.0, 3.815, 0.0)) is stand


def test_place_without_room_is_kept() -> None:
    rig = rig_with()
    stand = rig.model.of(Objects).stands["table_a"]
    crate = rig.model.map.with_points(np.array([[stand.x_m, stand.y_m - 0.1]]), 0.1)
    assert followed(rig, NEARER_A, crate) is stand


def test_map_and_sensed_cells_follow_a_measured_surface() -> None:
    rig = rig_with()
    model = rig.model
    given = model.map
    front = np.array([[2.0, 3.45], [2.0, 4.08], [0.5, 0.5]])  # before, and at the back of, table A
    model.sensed_cells = np.array([[2.0, 3.42, 12.0, 1.0], [0.5, 0.5, 12.0, 1.0]])
    assert not model.is_redrawn()
    model.of(Objects).surface_poses = (SurfacePose("table_a", NEARER_A, COVARIANCE),)
    merged = model.redraw_moved()
    rows = tuple(model.map.to_cell(front).T)
    assert given.occupied[rows].tolist() == [False, True, False]
    assert model.map.occupied[rows].tolist() == [True, False, False]
    assert merged.occupied[rows].tolist() == [True, False, True]
    assert model.sensed_cells[:, :2].tolist() == [[0.5, 0.5]]
    assert model.is_redrawn() and model.map.movable is given.movable
    other = rig_with().model
    other.set_state(model.state())
    assert (other.map.occupied == model.map.occupied).all()
    model.of(Objects).surface_poses = ()
    model.redraw_moved()
    assert model.map is given and not model.is_redrawn()


def test_fixed_surfaces_are_not_measured_before_arrival(tmp_path: Path) -> None:
    fixed = changed(tmp_path, "objects.yaml", ("x_m: 5.2\n", "x_m: 5.2\n    fixed: true\n"))
    rig = rig_with(objects=fixed)
    assert rig.model.measuring(rig.robot, "table_b", lambda **_: None) is None
    assert rig.model.measuring(rig.robot, "table_a", lambda **_: None) is not None
    assert rig.model.measuring(rig.robot, "home", lambda **_: None) is None
    rig.model.of(Objects).surface_poses = (SurfacePose("table_a", NEARER_A, COVARIANCE),)
    assert rig.model.measuring(rig.robot, "table_a", lambda **_: None) is None


@pytest.mark.slow
def test_base_stands_at_a_moved_table_as_at_one_that_was_not(tmp_path: Path) -> None:
    moved = ("name: table_a, x_m: 2.0, y_m: 3.8", "name: table_a, x_m: 2.03, y_m: 3.72, heading_deg: 3")
    rig = rig_with(world=changed(tmp_path, "world.yaml", moved), seed=3)
    outcome = rig.do(MoveTo(place="table_a"))
    assert isinstance(outcome, Success), outcome
    objects = rig.model.of(Objects)
    wanted = objects.stands["table_a"].pose.relative_to(objects.objects.surfaces["table_a"].floor)
    true = scene_of(rig).base.relative_to(NEARER_A)
    assert true.distance(wanted) < 0.075  # up to 60 mm further away, where cells are coarse
    assert math.degrees(true.turn(wanted)) < 1.5
    assert outcome.evidence["surface_off_mm"] == pytest.approx(85.0, abs=15.0)
