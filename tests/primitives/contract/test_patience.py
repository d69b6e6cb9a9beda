"""Tests of restoring that a fault breaks off, and that is tried again."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import ClassVar

import numpy as np
import pytest
from pydantic import PrivateAttr

from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.base import Base
from handcart.backends.robot.robot import Robot
from handcart.evaluation.conformance.faults.fault import Fault, FaultKind
from handcart.evaluation.conformance.faults.faulty_backend import FaultyBackend
from handcart.primitives.contract.action_primitive import ActionPrimitive, Periods
from handcart.primitives.contract.attempt import attempt
from handcart.primitives.driving.move_to import MoveTo
from handcart.primitives.knowledge.world_model import ModelView
from handcart.primitives.outcomes.discrepancy import Discrepancy, NeedsPerson
from handcart.primitives.outcomes.outcome import Fail, GiveUp, Outcome
from handcart.primitives.restoring.patience import Patience
from handcart.primitives.restoring.retrace import retrace
from handcart.primitives.restoring.snapshot import Snapshot
from handcart.primitives.restoring.trace import Moment, Trace
from tests.primitives.conftest import Rig

PERIODS = 40
STUCK_AT = {"arm": 20, "base": 120}
"""Period in which a fault holds each part."""


class Reach(ActionPrimitive):
    """Drives ahead while the arm turns, and fails; its way back is broken off some times."""

    breaks: int = 1
    person: bool = False
    needs: ClassVar = (Base, Arm)
    _left: int = PrivateAttr(default=0)
    _turned: list[float] = PrivateAttr(default_factory=list)

    def motion(self, robot: Robot, model: ModelView) -> Periods:
        self._left = self.breaks
        for _ in range(PERIODS):
            robot.base.drive(0.1, 0.0)
            robot.arm.move(robot.arm.command() + np.array([0.01, 0, 0, 0, 0, 0]))
            yield
        raise Discrepancy("the shelf is empty")

    def restore(self, robot: Robot, model: ModelView, start: Snapshot, trace: Trace) -> Periods:
        for number, _ in enumerate(retrace(robot, start, trace)):
            self._turned.append(float(robot.arm.command()[0] - start.joint_command[0]))
            if number > 20 and self._left:
                self._left -= 1
                if self.person:
                    raise NeedsPerson("somebody holds the arm")
                raise RuntimeError("the drive refuses")
            yield


class Nod(ActionPrimitive):
    """Turns the arm, and fails."""

    needs: ClassVar = (Arm,)

    def motion(self, robot: Robot, model: ModelView) -> Periods:
        for _ in range(PERIODS):
            robot.arm.move(robot.arm.command() + np.array([0.01, 0, 0, 0, 0, 0]))
            yield
        raise Discrepancy("nobody nods back")


def ending(rig: Rig, primitive: ActionPrimitive, patience: Patience) -> Outcome:
    """Run one attempt."""
    outcome: Outcome = rig.drive(attempt(primitive, rig.robot, rig.model, patience=patience))
    return outcome


@pytest.mark.parametrize(("attempts", "kind"), [(1, GiveUp), (2, GiveUp), (3, Fail)])
def test_restoring_broken_off_twice_needs_a_third_try(
    make_rig: Callable[..., Rig], attempts: int, kind: type
) -> None:
    outcome = ending(make_rig(), Reach(breaks=2), Patience(attempts, 0.5))
    assert isinstance(outcome, kind)
    assert "the shelf is empty" in str(outcome)


def test_second_try_continues_where_the_first_ended(make_rig: Callable[..., Rig]) -> None:
    rig, reach = make_rig(), Reach()
    assert isinstance(ending(rig, reach, Patience(2, 1.0)), Fail)
    turned = np.array(reach._turned)
    assert turned[0] > 0.3 and turned[-1] == pytest.approx(0.0, abs=1e-9)
    assert np.diff(turned).max() < 0.02, "the arm never goes back towards the goal"


def test_restoring_that_needs_a_person_is_not_tried_again(make_rig: Callable[..., Rig]) -> None:
    outcome = ending(make_rig(), Reach(person=True), Patience(5, 0.1))
    assert isinstance(outcome, GiveUp)
    assert outcome.reason.endswith("restoring failed: somebody holds the arm")


@pytest.mark.slow
@pytest.mark.parametrize("part", ["arm", "base"])
@pytest.mark.parametrize(("attempts", "kind"), [(1, GiveUp), (3, Fail)])
def test_part_stuck_for_seconds_is_brought_back_later(
    make_rig: Callable[..., Rig], part: str, attempts: int, kind: type
) -> None:
    rig = make_rig()
    faulty = FaultyBackend(rig.robot.backend)
    robot = Robot(faulty, rig.robot.spec, rig.robot.pose, rig.model.map)
    primitive = Nod() if part == "arm" else MoveTo(place="shelf_1")
    periods, bumps = attempt(primitive, robot, rig.model, patience=Patience(attempts, 3.0)), 0
    outcome = None
    for number in itertools.count():
        try:
            next(periods)
        except StopIteration as end:
            outcome = end.value
            break
        bumps = max(bumps, len(rig.model.bumps))
        if number == STUCK_AT[part]:
            faulty.inject(Fault(FaultKind.STUCK, periods=60))
        robot.step()
    assert faulty.bitten and isinstance(outcome, kind)
    assert bumps == (0 if part == "arm" else 2)
    assert len(rig.model.bumps) == (bumps if kind is GiveUp else 0), (
        "its drives held it, nothing stands there"
    )


def test_left_trace_keeps_fingers_that_moved_meanwhile(make_rig: Callable[..., Rig]) -> None:
    robot = make_rig().robot
    joints = robot.arm.command()
    way, back = Trace(robot), Trace(robot)
    opened = [0.0, 0.04, 0.04, 0.0, 0.0]  # it opens above the block, grips it, and lifts it to where it was
    away = [0.0, 0.0, 0.1, 0.1, 0.0]
    way.moments = [Moment(robot.pose, joints + a, g) for a, g in zip(away, opened, strict=True)]
    back.moments = way.moments[4:]
    left = way.left_after(back)
    grips = [moment.grip for moment in left.moments]
    assert left.is_rest and [grip for grip, _ in itertools.groupby(grips)] == [0.0, 0.04, 0.0]
    assert max(float(moment.joints[0] - joints[0]) for moment in left.moments) == pytest.approx(0.1)


def test_left_trace_has_no_step_that_is_too_large(make_rig: Callable[..., Rig]) -> None:
    """A stuck arm was commanded on."""
    robot = make_rig().robot
    joints = robot.arm.command()
    way, back = Trace(robot), Trace(robot)
    way.moments = [Moment(robot.pose, joints, 0.0)]
    back.moments = [Moment(robot.pose, joints + turned, 0.0) for turned in (0.0, 0.2, 0.5)]
    left = np.array([moment.joints for moment in way.left_after(back).moments])
    assert np.abs(np.diff(left, axis=0)).max() <= float(robot.joint_speeds.max()) * robot.period + 1e-9
    assert np.allclose(left[-1], joints + 0.5) and np.allclose(left[0], joints)
