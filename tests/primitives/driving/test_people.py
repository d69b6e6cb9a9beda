"""MOVE_TO among people who walk and do not stop for the robot, on the kinematic backend."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from benchmarks.driving.cluttered_robot import write_robot
from handcart.primitives.driving.move_to import MoveTo
from handcart.primitives.outcomes.outcome import Fail, Outcome, Success
from tests.primitives.conftest import Rig

STANDING_SPEED_M_S = 0.02
DOORWAY = """\
  - {name: left wing, x_m: 2.75, y_m: 4.3, size_m: [5.4, 0.1, 1.0]}
  - {name: right wing, x_m: 7.2, y_m: 4.3, size_m: [1.5, 0.1, 1.0]}
"""


class Among(NamedTuple):
    """Course of a drive among people."""

    outcome: Outcome
    by_robot: int
    """Contacts that began while the base moved."""
    while_standing: int
    standing_s: float


def drive(
    rig: Rig, primitive: MoveTo, cancel: Callable[[], bool] = lambda: False, limit_s: float = 200.0
) -> Among:
    """Run a drive, and count its contacts by the true speed of the base."""
    counts, before, stood = [0, 0], len(rig.scene.contacts), 0.0
    base, was, step = rig.scene.base, 0.0, rig.robot.step

    def watched_step(paused: bool = False) -> None:
        nonlocal before, stood, base, was
        step(paused)
        assert rig.robot.time < limit_s
        speed = max(abs(rig.robot.command.along), was)
        counts[int(speed < STANDING_SPEED_M_S)] += len(rig.scene.contacts) - before
        before, was = len(rig.scene.contacts), base.distance(rig.scene.base) / rig.robot.period
        base, stood = rig.scene.base, stood + rig.robot.period * (speed < STANDING_SPEED_M_S)

    rig.robot.step = watched_step  # type: ignore[method-assign]
    outcome = rig.run(primitive, cancel)
    return Among(outcome, counts[0], counts[1], stood)


def people(*lines: str, more: str = "") -> str:
    """Lines of a world's file."""
    return "passers:\n" + "".join(f"  - {{{line}}}\n" for line in lines) + more


@pytest.mark.slow
def test_person_who_steps_in_front_of_the_base_is_let_pass(make_rig: Callable[..., Rig]) -> None:
    """K15: the base brakes in time and continues behind the person."""
    rig = make_rig(people("name: anna, waypoints_m: [[4.4, 0.6], [4.4, 5.4]], starts_s: 5.5, at_end: stay"))
    found = drive(rig, MoveTo(place="shelf_1"))
    assert isinstance(found.outcome, Success), found
    assert found.by_robot == 0
    assert rig.restored == []


@pytest.mark.slow
def test_commands_before_a_person_keep_the_limits(make_rig: Callable[..., Rig], tmp_path: Path) -> None:
    """The base slows down for a person whom it has seen coming, and drives on again, within its limits.

    Periods in which the guard finds too little room are exempt: it acts only when braking just suffices. So
    is a person who is noticed too late to brake for; nobody is here.
    """
    crossing = (
        "name: anna, waypoints_m: [[4.4, 5.4], [4.4, 0.6]], starts_s: 2.5, at_end: stay, speed_m_s: 0.8"
    )
    rig = make_rig(people(crossing), robot=str(write_robot(tmp_path, (0.22,), 1.0, "scan")))
    robot, step, beyond, shares = rig.robot, rig.robot.step, [], []
    most = robot.drive_limits.acceleration * robot.period + 1e-6
    sharpest = robot.drive_limits.turn_acceleration * robot.period + 1e-6

    def watched_step(paused: bool = False) -> None:
        last = robot.command
        step(paused)
        shares.append(robot.base.share_for_people)
        now, jumps = robot.command, robot.held is None
        jumps &= abs(now.speed - last.speed) > most or abs(now.turn_rate - last.turn_rate) > sharpest
        beyond.extend([(robot.time, last, now, shares[-1])] if jumps else [])

    robot.step = watched_step  # type: ignore[method-assign]
    assert isinstance(rig.run(MoveTo(place="shelf_1", wait_s=30.0)), Success)
    assert beyond == []
    assert sum(0.0 < share < 1.0 for share in shares) > 3


@pytest.mark.slow
def test_person_who_stands_on_the_goal_is_a_named_restored_fail(make_rig: Callable[..., Rig]) -> None:
    """K16: waiting is bounded; the Fail names the person, which is not kept as an obstacle."""
    rig = make_rig(people("name: anna, waypoints_m: [[4.5, 2.6], [6.5, 4.6]], starts_s: 9, at_end: stay"))
    before = rig.scene.base
    found = drive(rig, MoveTo(place="shelf_1", wait_s=2.0))
    assert isinstance(found.outcome, Fail), found
    assert "a person is on the path to shelf_1" in found.outcome.reason
    assert found.outcome.cause.name == "blocked"
    assert math.dist(before[:2], rig.scene.base[:2]) < 0.03
    assert found.by_robot == 0
    near = np.hypot(*(rig.model.sensed_cells[:, :2] - (6.5, 4.6)).T) < 0.3
    assert not near.any()


@pytest.mark.slow
def test_crowd_that_never_ends_is_a_fail_within_the_wait(make_rig: Callable[..., Rig]) -> None:
    """K17: two people never leave the only doorway; the drive ends restored, without a contact."""
    crowd = "name: crowd, waypoints_m: [[5.9, 3.9], [5.9, 4.7]], speed_m_s: 0.6, group_m: [0.5]"
    rig = make_rig(people(crowd, more="surprises:\n" + DOORWAY))
    before = rig.scene.base
    found = drive(rig, MoveTo(place="shelf_1", wait_s=1.0))
    assert isinstance(found.outcome, Fail), found
    assert "on the path to shelf_1" in found.outcome.reason
    assert math.dist(before[:2], rig.scene.base[:2]) < 0.03
    assert found.by_robot == 0


@pytest.mark.slow
def test_person_from_behind_while_restoring_is_let_pass(make_rig: Callable[..., Rig]) -> None:
    """K18: the base waits until the person has passed, and is restored after."""
    walk = "name: anna, waypoints_m: [[1.0, 5.2], [1.0, 3.4], [4.4, 0.9]], starts_s: 8, speed_m_s: 0.8"
    rig = make_rig(people(f"{walk}, at_end: stay"))
    before = rig.scene.base
    found = drive(rig, MoveTo(place="shelf_1"), lambda: rig.robot.time > 9.0)
    assert isinstance(found.outcome, Fail), found
    assert math.dist(before[:2], rig.scene.base[:2]) < 0.03
    assert found.by_robot == 0


@pytest.mark.slow
def test_standing_base_that_is_run_into_stays_and_knows_its_pose(make_rig: Callable[..., Rig]) -> None:
    head_on = "name: bert, waypoints_m: [[1.0, 5.4], [1.0, 0.5]], at_end: stay"
    rig = make_rig(people(head_on))
    found = drive(rig, MoveTo(place="shelf_1", wait_s=10.0))
    assert isinstance(found.outcome, Success), found
    assert found.by_robot == 0
    assert rig.robot.localization.displacements == 0


@pytest.mark.slow
def test_walker_leaves_no_smear_in_what_is_sensed(make_rig: Callable[..., Rig]) -> None:
    rig = make_rig(people("name: anna, waypoints_m: [[2.0, 2.0], [2.0, 5.4]], at_end: stay, starts_s: 1"))
    drive(rig, MoveTo(place="shelf_1"))
    on_the_way = (np.abs(rig.model.sensed_cells[:, 0] - 2.0) < 0.4) & (rig.model.sensed_cells[:, 1] < 4.5)
    assert not on_the_way.any()


@pytest.mark.slow
def test_person_in_the_doorway_behind_gets_time_to_leave(make_rig: Callable[..., Rig]) -> None:
    """K18: a person closes the only way back for 14 s; the base waits, and is restored after."""
    walk = "waypoints_m: [[7.6, 3.0], [5.95, 4.3], [7.6, 3.0]], pauses_s: [0, 14, 0]"
    rig = make_rig(people(f"name: anna, {walk}, starts_s: 17.5, at_end: stay", more="surprises:\n" + DOORWAY))
    before = rig.scene.base
    found = drive(rig, MoveTo(place="shelf_1", wait_s=1.0), lambda: rig.robot.time > 19.0)
    assert isinstance(found.outcome, Fail), found
    assert math.dist(before[:2], rig.scene.base[:2]) < 0.03
    assert found.by_robot == 0
