"""OPEN and CLOSE on drawers and doors."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from handcart.backends.robot.robot import Robot
from handcart.evaluation.trials.rig import Rig
from handcart.primitives.contract.action_primitive import Periods
from handcart.primitives.doors.close_door import CloseDoor
from handcart.primitives.doors.doors import Doors
from handcart.primitives.doors.handle_grasp import PlannedHandle, plan_handle
from handcart.primitives.doors.move_door import MoveDoor
from handcart.primitives.doors.open_door import OpenDoor
from handcart.primitives.objects.knowledge.objects import WALL_NAME
from handcart.primitives.objects.site.roomy_motion import move_with_room, walls_to_try
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.outcome import Fail, GiveUp, Success
from handcart.robotics.geometry.transform import transform
from handcart.robotics.kinematics.shapes import Box, corners

from .door_rig import opening, props, rig_at

FRICTION = "friction_n: 6"


@pytest.mark.slow
def test_open_drawer_is_as_open_as_asked_and_closes_again(tmp_path: Path) -> None:
    with rig_at("drawer", tmp_path) as rig:
        assert isinstance(rig.do(OpenDoor(door="drawer", travel_mm=200.0)), Success)
        state = rig.model.of(Doors).state_of("drawer")
        assert state is not None and state.motion == "sliding"
        assert opening(rig, "drawer") == pytest.approx(0.2, abs=0.006)
        assert state.opened == pytest.approx(opening(rig, "drawer"), abs=0.002)
        assert isinstance(rig.do(CloseDoor(door="drawer")), Success)
        assert opening(rig, "drawer") == pytest.approx(0.0, abs=0.002)


@pytest.mark.slow
def test_open_door_finds_its_hinge(tmp_path: Path) -> None:
    with rig_at("cupboard", tmp_path) as rig:
        outcome = rig.do(OpenDoor(door="cupboard", angle_deg=20.0))
        assert isinstance(outcome, Success)
        state = rig.model.of(Doors).state_of("cupboard")
        assert state is not None and state.hinge is not None
        assert math.degrees(opening(rig, "cupboard")) == pytest.approx(20.0, abs=0.6)
        assert state.hinge.radius == pytest.approx(0.62, abs=0.01)
        assert float(outcome.evidence["force_n"]) < 15.0


@pytest.mark.slow
@pytest.mark.parametrize(
    "wrong",
    [
        f"{FRICTION}, jams_mm: 70",
        pytest.param(f"{FRICTION}, locked: true", marks=pytest.mark.slow),
        pytest.param("friction_n: 60", marks=pytest.mark.slow),
    ],
)
def test_drawer_that_sticks_is_closed_after_the_fail(tmp_path: Path, wrong: str) -> None:
    inline = wrong.replace(", ", "\n    ")
    with rig_at("drawer", tmp_path, world=((FRICTION, inline),)) as rig:
        outcome = rig.do(OpenDoor(door="drawer"))
        assert isinstance(outcome, Fail) and outcome.cause == causes.ARM_BLOCKED
        assert opening(rig, "drawer") == pytest.approx(0.0, abs=0.005)
        assert rig.model.of(Doors).state_of("drawer") is None


@pytest.mark.slow
def test_door_believed_a_drawer_is_found_hinged(tmp_path: Path) -> None:
    believed = (("    hinge: left\n", "    motion: sliding\n    hinge: left\n"),)
    with rig_at("cupboard", tmp_path, known=believed) as rig:
        assert isinstance(rig.do(OpenDoor(door="cupboard", travel_mm=180.0)), Success)
        state = rig.model.of(Doors).state_of("cupboard")
        assert state is not None and state.motion == "hinged"
        assert state.opened == pytest.approx(opening(rig, "cupboard"), abs=0.01)


@pytest.mark.slow
def test_handle_far_from_its_place_is_found_by_its_tag(tmp_path: Path) -> None:
    known = (("y_m: 1.0, height_m", "y_m: 1.03, height_m"),)
    with rig_at("drawer", tmp_path, known=known) as rig:
        assert isinstance(rig.do(OpenDoor(door="drawer")), Success)


@pytest.mark.slow
def test_drawer_that_moves_after_it_was_let_go_is_given_up(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    let_go = MoveDoor._let_go

    def and_rolls_on(primitive: MoveDoor, robot: Robot) -> Periods:
        yield from let_go(primitive, robot)
        props(rig).put("drawer", opening(rig, "drawer") + 0.03)

    monkeypatch.setattr(MoveDoor, "_let_go", and_rolls_on)
    with rig_at("drawer", tmp_path) as rig:
        outcome = rig.do(OpenDoor(door="drawer", travel_mm=60.0, stow=False))
        assert isinstance(outcome, GiveUp)
        assert "drawer doesn't stay" in outcome.reason
        assert rig.model.of(Doors).state_of("drawer") is None


@pytest.mark.slow
def test_close_that_is_blocked_on_the_way_leaves_the_drawer_open(tmp_path: Path) -> None:
    with rig_at("drawer", tmp_path) as rig:
        assert isinstance(rig.do(OpenDoor(door="drawer", travel_mm=60.0, stow=False)), Success)
        for part in props(rig).parts.values():
            part.spec = part.spec.model_copy(update={"friction_n": 80.0})
        outcome = rig.do(CloseDoor(door="drawer"))
        assert isinstance(outcome, Fail) and outcome.cause == causes.ARM_BLOCKED
        assert opening(rig, "drawer") == pytest.approx(0.06, abs=0.006)


def test_closed_door_is_not_closed_again(tmp_path: Path) -> None:
    with rig_at("drawer", tmp_path) as rig:
        outcome = rig.do(CloseDoor(door="drawer"))
        assert isinstance(outcome, Fail) and outcome.cause == causes.MISPLACED


def _with_wall(rig: Rig) -> None:
    """Mark a wall on the model's map, flush with the front of the cupboard; a cell of it is in front."""
    grid = rig.model.map
    occupied = grid.occupied.copy()
    low, high = grid.to_cell(np.array([[3.92, 2.0], [4.1, 3.95]]))
    occupied[low[0] : high[0], low[1] : high[1]] = True
    rig.model.map = grid._replace(occupied=occupied)


def test_walls_around_a_door_are_kept_clear_of_but_not_the_door(tmp_path: Path) -> None:
    with rig_at("cupboard", tmp_path) as rig:
        _with_wall(rig)
        model: Any = rig.model.view(OpenDoor(door="cupboard"))  # type: ignore[arg-type]
        walls = walls_to_try(rig.robot, model, model.of(Doors).swept_areas())[-1]
        boxes = [corners(wall.seen_from(rig.robot.pose.lift()))[:, :2] for wall in walls]
        covered = [
            any((box.min(axis=0) < point).all() and (point < box.max(axis=0)).all() for box in boxes)
            for point in ((3.94, 2.7), (3.94, 3.0), (3.94, 3.3), (3.94, 3.8))
        ]
        assert covered == [True, False, False, True]


@pytest.mark.slow
def test_door_is_opened_wide_with_a_grasp_that_allows_it(tmp_path: Path) -> None:
    """With the grasp of the most lever, the arm would touch itself at the end of the path."""
    with rig_at("cupboard", tmp_path) as rig:
        assert isinstance(outcome := rig.do(OpenDoor(door="cupboard", angle_deg=60.0)), Success), outcome
        assert math.degrees(opening(rig, "cupboard")) == pytest.approx(60.0, abs=0.6)


def test_handle_is_not_followed_into_a_wall_nor_let_go_before_one(tmp_path: Path) -> None:
    """A post behind the hand blocks the path of the drawer, or only the withdrawal at its end, or nothing."""
    with rig_at("drawer", tmp_path) as rig:
        primitive = OpenDoor(door="drawer")
        model: Any = rig.model.view(primitive)  # type: ignore[arg-type]
        joint, door = primitive.believed_joint(rig.robot, model), primitive.known(model)
        handle = joint.handle_at(0.0)
        front = primitive._front(model, joint, handle)
        found = []
        for away in (0.40, 0.55, 0.70):
            post = Box(handle @ transform((away, 0.0, 0.0)), (0.02, 0.02, 0.02), "post")
            plan = plan_handle(rig.robot, door, handle, joint, (0.0, 0.2), front, (post,))
            assert plan is not None
            found.append(plan.reach)
    assert found[0] < 0.7 < found[1] < 1.0 == found[2]


@pytest.mark.parametrize(("begins_at", "reaches"), [(0.08, True), (0.4, False)])
def test_front_is_not_moved_into_the_base(tmp_path: Path, begins_at: float, reaches: bool) -> None:
    """The front, or what juts out of it below the handle, is moved by 0.2 m towards the base."""
    with rig_at("drawer", tmp_path) as rig:
        primitive = OpenDoor(door="drawer")
        model: Any = rig.model.view(primitive)  # type: ignore[arg-type]
        joint, door = primitive.believed_joint(rig.robot, model), primitive.known(model)
        handle = joint.handle_at(0.0)
        low = Box(handle @ transform((begins_at, 0.0, -0.6)), (0.02, 0.6, 0.3), "front")
        plan = plan_handle(rig.robot, door, handle, joint, (0.0, 0.2), low, ())
        assert plan is not None
        assert (plan.reach == 1.0) is reaches


@pytest.mark.parametrize(("away", "is_in_the_way"), [(0.12, True), (0.35, False), (-0.01, False)])
def test_front_is_not_moved_into_a_known_thing(tmp_path: Path, away: float, is_in_the_way: bool) -> None:
    """The drawer is opened by 0.2 m; what it touches already is the frame that it is built into."""
    with rig_at("drawer", tmp_path) as rig:
        primitive = OpenDoor(door="drawer")
        model: Any = rig.model.view(primitive)  # type: ignore[arg-type]
        joint, door = primitive.believed_joint(rig.robot, model), primitive.known(model)
        handle = joint.handle_at(0.0)
        front = primitive._front(model, joint, handle)
        face, width = front.size[0] / 2, front.size[1] / 2
        at = front.pose @ transform((face + away + 0.01, width - 0.02, 0.0))
        thing = Box(at, (0.02, 0.02, front.size[2]), "thing")
        plan = plan_handle(rig.robot, door, handle, joint, (0.0, 0.2), front, (thing,))
        assert plan is not None
        assert (plan.reach < 1.0) is is_in_the_way


@pytest.mark.slow
def test_arm_goes_home_clear_of_the_opened_door(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    kept_clear: list[Any] = []

    def move(*arguments: Any, **options: Any) -> Periods:
        kept_clear[:] = options.get("also_around", ())
        yield from move_with_room(*arguments, **options)

    monkeypatch.setattr("handcart.primitives.doors.move_door.move_with_room", move)
    with rig_at("cupboard", tmp_path) as rig:
        assert isinstance(rig.do(OpenDoor(door="cupboard", angle_deg=20.0)), Success)
        front, scene = props(rig).parts["door cupboard"], rig.backend.scene  # type: ignore[attr-defined]
        true = np.linalg.inv(scene.world_T_base) @ front.pose @ front.thing_T_middle
        assert [body.name for body in kept_clear] == [front.name]
        assert kept_clear[0].pose[:3, 3] == pytest.approx(true[:3, 3], abs=0.03)


@pytest.mark.slow
def test_door_in_a_mapped_wall_is_opened(tmp_path: Path) -> None:
    with rig_at("cupboard", tmp_path) as rig:
        _with_wall(rig)
        assert isinstance(rig.do(OpenDoor(door="cupboard", angle_deg=20.0)), Success)
        assert math.degrees(opening(rig, "cupboard")) == pytest.approx(20.0, abs=0.6)


@pytest.mark.parametrize("is_blocked", [False, True])
def test_handle_is_taken_clear_of_walls_where_that_is_possible(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, is_blocked: bool
) -> None:
    planned: list[bool] = []

    def plan(*arguments: Any) -> PlannedHandle | None:
        has_wall = any(body.name == WALL_NAME for body in arguments[-1])
        planned.append(has_wall)
        return None if is_blocked and has_wall else PlannedHandle(np.zeros(6), np.eye(4), 1.0, 0.5)

    monkeypatch.setattr("handcart.primitives.doors.move_door.plan_handle", plan)
    with rig_at("cupboard", tmp_path) as rig:
        _with_wall(rig)
        primitive = OpenDoor(door="cupboard")
        model: Any = rig.model.view(primitive)  # type: ignore[arg-type]
        joint = primitive.believed_joint(rig.robot, model)
        for _ in primitive._planned(rig.robot, model, primitive.known(model), joint, (0.0, 0.3)):
            rig.robot.step()
    assert planned == ([True, False] if is_blocked else [True])
