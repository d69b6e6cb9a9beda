"""Tables that were moved against their file: measured where the robot is at them, and used."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from handcart.evaluation.trials.rig import Rig
from handcart.primitives.driving.move_to import MoveTo
from handcart.primitives.objects.knowledge.objects import Objects, SurfacePose
from handcart.primitives.objects.look_for import LookFor
from handcart.primitives.objects.pick import Pick
from handcart.primitives.objects.place_object import PlaceObject
from handcart.primitives.outcomes.outcome import Success
from handcart.robotics.geometry.pose2 import Pose2

from ..fetching import at_table_a, changed, rig_with, scene_of

MOVED_B = "name: table_b, x_m: 5.222, y_m: 1.98, heading_deg: 3"
COVARIANCE = ((4e-6, 0.0, 0.0), (0.0, 4e-6, 0.0), (0.0, 0.0, 1e-5))


def measured(rig: Rig, name: str) -> Pose2:
    return rig.model.of(Objects).surface(name).floor


def test_measured_surface_takes_spots_and_beliefs_along() -> None:
    objects = rig_with().model.of(Objects)
    turned = Pose2(5.2, 2.0, math.pi / 2)
    objects.surface_poses = (SurfacePose("table_b", turned, COVARIANCE),)
    left = objects.surface("table_b").spots["left"]  # 0.15 m before the middle, 0.2 m to the left
    assert (left.x_m, left.y_m) == pytest.approx((5.0, 1.85))
    assert left.heading_deg == pytest.approx(90.0)
    assert objects.surface("table_b").spots["right"].heading_deg is None
    assert objects.surface("table_a") is objects.objects.surfaces["table_a"]
    objects.surface_poses = (SurfacePose("table_a", Pose2(2.03, 3.8, 0.0), COVARIANCE),)
    assert objects.believed("parcel_1") == pytest.approx((1.93, 3.65, 0.0))


def test_measured_surfaces_survive_a_checkpoint() -> None:
    model, other = rig_with().model, rig_with().model
    model.of(Objects).surface_poses = (SurfacePose("table_b", Pose2(5.2, 2.0, 0.1), COVARIANCE),)
    other.set_state(model.state())
    assert other.of(Objects).surface_poses == model.of(Objects).surface_poses
    assert model.taken_changes()["surface_poses"][0][0] == "table_b"


def test_tables_are_marked_on_the_map_unless_they_are_fixed(tmp_path: Path) -> None:
    at_b = np.array([[4.85, 2.0], [5.2, 2.75], [5.2, 2.0], [4.6, 2.0], [5.99, 2.0]])
    for rig, expected in (
        (rig_with(), [True, True, True, False, False]),
        (
            rig_with(changed(tmp_path, "objects.yaml", ("x_m: 5.2\n", "x_m: 5.2\n    fixed: true\n"))),
            [False] * 5,
        ),
    ):
        marked = rig.model.map.movable
        field = rig.robot.localization.map_field
        assert marked is not None and field is not None
        assert marked[tuple(rig.model.map.to_cell(at_b).T)].tolist() == expected
        assert field.map.movable is marked  # the localizer has it


def test_floor_and_low_things_are_not_marked() -> None:
    objects = rig_with().model.of(Objects).objects
    table = objects.surfaces["table_a"]
    assert table.model_copy(update={"height_m": 0.0}).movable_area() is None
    bin_ = table.model_copy(update={"height_m": 0.01, "walls": ("+x",), "wall_m": 0.18}).movable_area()
    assert bin_ is not None and bin_.high == pytest.approx(0.19)


@pytest.mark.slow
def test_moved_table_is_measured_from_its_place(tmp_path: Path) -> None:
    moved = ("name: table_a, x_m: 2.0, y_m: 3.8", "name: table_a, x_m: 1.985, y_m: 3.826, heading_deg: -3")
    rig = at_table_a(world=changed(tmp_path, "world.yaml", moved), seed=3)
    outcome = rig.do(LookFor(object="parcel_1"))
    assert isinstance(outcome, Success), outcome
    found = measured(rig, "table_a").relative_to(rig.robot.pose)  # to compare without the base's own error
    true = Pose2(1.985, 3.826, math.radians(-3.0)).relative_to(scene_of(rig).base)
    assert found.distance(true) < 0.008
    assert math.degrees(found.turn(true)) < 0.3
    assert outcome.evidence["surface_off_deg"] == pytest.approx(3.0, abs=0.6)


@pytest.mark.slow
def test_board_with_room_below_keeps_its_pose(tmp_path: Path) -> None:
    board = changed(
        tmp_path, "objects.yaml", ("y_m: 3.8, height_m: 0.6", "y_m: 3.8, height_m: 0.6, thickness_m: 0.03")
    )
    rig = at_table_a(objects=board, seed=3)
    assert isinstance(rig.do(LookFor(object="parcel_1")), Success)
    assert rig.model.of(Objects).surface_poses == ()


@pytest.mark.slow
@pytest.mark.parametrize("wait_s", [5.0, 0.0])
def test_crate_where_the_table_would_be_measured_is_driven_around(tmp_path: Path, wait_s: float) -> None:
    """It blocks the stop before the place, 4.11 m, 2.0 m, but not the place itself."""
    crate = (
        "surprises:\n  - {name: crate, x_m: 3.75, y_m: 2.0, size_m: [0.4, 0.3, 0.4], appears_s: 2}\nobjects:"
    )
    rig = rig_with(world=changed(tmp_path, "world.yaml", ("objects:", crate)))
    outcome = rig.do(MoveTo(place="table_b", wait_s=wait_s))
    assert isinstance(outcome, Success), outcome
    assert not scene_of(rig).contacts


@pytest.mark.slow
def test_object_is_put_at_the_spot_of_a_moved_table(tmp_path: Path) -> None:
    world = changed(tmp_path, "world.yaml", ("name: table_b, x_m: 5.2, y_m: 2.0", MOVED_B))
    rig = at_table_a(world=world)
    for primitive in (
        LookFor(object="parcel_1"),
        Pick(object="parcel_1", to="table_b", spot="left"),
        MoveTo(place="table_b"),
        PlaceObject(surface="table_b", spot="left"),
    ):
        outcome = rig.do(primitive)
        assert isinstance(outcome, Success), outcome
    table = Pose2(5.222, 1.98, math.radians(3.0))
    spot = table.compose(Pose2(-0.15, 0.2, 0.0))
    true = scene_of(rig).thing_named("object parcel_1").pose
    assert np.hypot(true[0, 3] - spot.x, true[1, 3] - spot.y) < 0.010
    assert math.degrees(math.atan2(true[1, 0], true[0, 0])) == pytest.approx(3.0, abs=1.0)
