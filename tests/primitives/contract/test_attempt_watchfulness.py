"""Tests of monitoring after the motion: while an attempt confirms, halts, comes to rest and restores."""

from __future__ import annotations

from collections.abc import Callable, Generator
from typing import Any, ClassVar

import numpy as np
import pytest

from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.base import Base
from handcart.backends.robot.robot import Robot
from handcart.evaluation.layers.layered_backend import LayeredBackend
from handcart.primitives.contract.action_primitive import ActionPrimitive, Periods
from handcart.primitives.contract.attempt import NOT_ALONE, PUSHED_REASON
from handcart.primitives.knowledge.world_model import ModelView
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy, NeedsPerson
from handcart.primitives.outcomes.outcome import Fail, GiveUp, Success
from handcart.primitives.restoring.retrace import retrace
from handcart.primitives.restoring.snapshot import REST_PERIODS, Snapshot
from handcart.primitives.restoring.trace import Trace
from handcart.robotics.geometry.pose2 import Pose2
from tests.primitives.conftest import Rig


def push(scene: Any) -> None:
    """Push the base by 60 mm; its wheels do not turn."""
    x, y, heading = scene.base
    scene.base = Pose2(x + 0.06, y, heading)


class Stands(ActionPrimitive):
    """Stays at rest, and is pushed in a period of its effect, or of its restoring."""

    effect_s: float = 0.0
    restore_s: float = 0.0
    push_at_s: float = 1.2
    scene: Any = None
    needs: ClassVar = (Base,)

    def motion(self, robot: Robot, model: ModelView) -> Periods:
        yield
        if self.restore_s:
            raise Discrepancy("nobody is there")

    def effect(self, robot: Robot, model: ModelView) -> Generator[None, None, bool]:
        yield from self._stand(robot, self.effect_s)
        return True

    def restore(self, robot: Robot, model: ModelView, start: Snapshot, trace: Trace) -> Periods:
        yield from self._stand(robot, self.restore_s)

    def _stand(self, robot: Robot, seconds: float) -> Periods:
        for period in range(round(seconds / robot.period)):
            if period == round(self.push_at_s / robot.period):
                push(self.scene)
            yield


class Reaches(ActionPrimitive):
    """Swings the arm, then fails or needs a person; the robot may be moved while it restores."""

    person: bool = False
    needs: ClassVar = (Arm,)

    def motion(self, robot: Robot, model: ModelView) -> Periods:
        swing = np.zeros(len(robot.arm.command()))
        swing[0] = 0.01
        for _ in range(30):
            robot.arm.move(robot.arm.command() + swing)
            yield
        if self.person:
            raise NeedsPerson("the arm squeaks")
        raise Discrepancy("nobody is there")


class Rolls(ActionPrimitive):
    """Drives, then needs a person, or has arrived."""

    person: bool = True
    needs: ClassVar = (Base,)

    def motion(self, robot: Robot, model: ModelView) -> Periods:
        for _ in range(10):
            robot.base.drive(0.2, 0.0)
            yield
        if self.person:
            raise NeedsPerson("a wheel squeaks")


class Jammed(LayeredBackend):
    """Backend whose arm does not move from the period on in which `jams` is true."""

    jams: Callable[[], bool] = staticmethod(lambda: False)

    def __init__(self, inner: Any) -> None:
        super().__init__(inner)
        self._held: Any = None

    def arm_joints(self, arm: Arm) -> Any:
        if self._held is None and self.jams():
            self._held = arm.joints().copy()
        return arm.joints() if self._held is None else self._held


class Coasting(LayeredBackend):
    """Its base rolls on for some periods after it was stopped; or for ever."""

    periods: int = 4

    def __init__(self, inner: Any) -> None:
        super().__init__(inner)
        self.left = 0
        self._driven = False

    def base_drive(self, base: Base, speed: float, turn_rate: float) -> None:
        self._driven, self.left = True, self.periods
        base.drive(speed, turn_rate)

    def step(self) -> None:
        if not self._driven and self.left:
            self.left -= 1
            next(part for part in self.inner.capabilities() if isinstance(part, Base)).drive(0.02, 0.0)
        self._driven = False
        self.inner.step()


def layered(rig: Any, kind: type[LayeredBackend]) -> Any:
    """The rig's robot on its backend in a layer; gives the layer."""
    backend = kind(rig.robot.backend)
    rig.robot = Robot(backend, rig.robot.spec, rig.robot.pose, rig.model.map)
    return backend


def test_a_push_just_before_success_is_seen(make_rig: Callable[..., Rig]) -> None:
    """The base is looked for once more right before Success, not only every few periods."""
    rig = make_rig()
    assert rig.run(Stands(effect_s=1.5, push_at_s=99.0, scene=rig.scene)) == Success({})
    missed = [
        seconds
        for seconds in np.arange(1.5, 2.0, 0.05)
        if isinstance(rig.run(Stands(effect_s=seconds, push_at_s=seconds - 0.05, scene=rig.scene)), Success)
    ]
    assert missed == []


def test_a_push_while_the_effect_is_observed_is_for_a_person(make_rig: Callable[..., Rig]) -> None:
    rig = make_rig()
    assert rig.run(Stands(effect_s=4.0, scene=rig.scene)) == GiveUp(PUSHED_REASON, cause=causes.DISPLACED)


def test_a_push_on_the_way_back_ends_restoring_at_once(make_rig: Callable[..., Rig]) -> None:
    rig = make_rig()
    outcome = rig.run(Stands(restore_s=6.0, scene=rig.scene))
    assert outcome == GiveUp(f"nobody is there; and restoring failed: {PUSHED_REASON}")
    assert rig.robot.time < 4.0


def test_a_joint_that_jams_on_the_way_back_ends_restoring_at_once(make_rig: Callable[..., Rig]) -> None:
    rig = make_rig()
    backend = layered(rig, Jammed)
    backend.jams = lambda: bool(rig.restored)
    outcome = rig.run(Reaches())
    assert isinstance(outcome, GiveUp)
    assert "restoring failed: joint 1 is 0." in outcome.reason


def test_a_second_primitive_on_the_way_back_is_noticed(make_rig: Callable[..., Rig]) -> None:
    """N12"""
    rig = make_rig()

    class Disturbed(Reaches):
        def restore(self, robot: Robot, model: ModelView, start: Snapshot, trace: Trace) -> Periods:
            for _ in retrace(robot, start, trace):
                robot.moved_by(rig)
                yield

    assert rig.run(Disturbed()) == GiveUp(f"nobody is there; and restoring failed: {NOT_ALONE}")


def test_a_giveup_comes_when_the_robot_stands(make_rig: Callable[..., Rig]) -> None:
    rig = make_rig()
    backend = layered(rig, Coasting)
    before = rig.robot.time
    assert rig.run(Rolls()) == GiveUp("a wheel squeaks")
    assert backend.left == 0
    assert rig.robot.time - before > (10 + Coasting.periods + REST_PERIODS) * rig.robot.period


@pytest.mark.slow
def test_no_success_for_a_robot_that_never_stands(make_rig: Callable[..., Rig]) -> None:
    rig = make_rig()
    layered(rig, Coasting).periods = 10_000
    outcome = rig.run(Rolls(person=False))
    assert not isinstance(outcome, Success)
    assert outcome.reason.startswith("the robot doesn't come to rest")


@pytest.mark.parametrize("moved_mm", [0.0, 60.0])
def test_by_wheels_alone_a_long_way_is_no_sure_return(make_rig: Callable[..., Rig], moved_mm: float) -> None:
    """With wheels as the only sensor, the uncertainty added on the way counts in the residuals."""
    rig = make_rig()
    rig.robot = Robot(rig.robot.backend, rig.robot.spec, rig.robot.pose, None)
    outcome = rig.run(Wanders(far_mm=moved_mm))
    assert rig.robot.localization.dead_reckoned
    assert isinstance(outcome, Fail | GiveUp)
    unsure = outcome.residuals["base_unsure_mm"]
    assert unsure == pytest.approx(0.0, abs=1e-6) if moved_mm == 0.0 else unsure > 0.3


class Wanders(ActionPrimitive):
    """Drives a distance, then fails."""

    far_mm: float
    needs: ClassVar = (Base,)

    def motion(self, robot: Robot, model: ModelView) -> Periods:
        yield
        start = robot.pose
        while 1e3 * robot.pose.distance(start) < self.far_mm:
            robot.base.drive(0.1, 0.0)
            yield
        raise Discrepancy("nobody is there")


class Stuck(ActionPrimitive):
    """Fails at once; while it restores, the base is commanded to drive but does not move."""

    needs: ClassVar = (Base,)

    def motion(self, robot: Robot, model: ModelView) -> Periods:
        yield
        raise Discrepancy("nobody is there")

    def restore(self, robot: Robot, model: ModelView, start: Snapshot, trace: Trace) -> Periods:
        for _ in range(round(60.0 / robot.period)):
            robot.base.drive(0.3, 0.0)
            yield


def test_a_base_that_is_stuck_on_the_way_back_is_given_up_soon(
    make_rig: Callable[..., Rig], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its drives are stuck for good: once this was noticed only after ten minutes."""
    rig = make_rig()
    base = rig.robot.backend.get(Base)  # type: ignore[type-abstract]
    monkeypatch.setattr(type(base), "drive", lambda self, speed, turn_rate: None)
    begun = rig.robot.time
    outcome = rig.run(Stuck())
    assert isinstance(outcome, GiveUp), outcome
    assert "the base doesn't move, though it is driven" in outcome.reason
    assert rig.robot.time - begun < 20.0
