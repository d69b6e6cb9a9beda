"""OPEN and CLOSE on drawers and doors."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from handcart.backends.robot.robot import Robot
from handcart.primitives.contract.action_primitive import Periods
from handcart.primitives.doors.close_door import CloseDoor
from handcart.primitives.doors.doors import Doors
from handcart.primitives.doors.move_door import MoveDoor
from handcart.primitives.doors.open_door import OpenDoor
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.outcome import Fail, GiveUp, Success

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
