"""Mutant primitives, each with one fault that the kit has to find."""

from __future__ import annotations

from collections.abc import Generator
from typing import Any

import numpy as np
from typing_extensions import override

from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.base import Base
from handcart.backends.capabilities.gripper import Gripper
from handcart.backends.robot.robot import Robot
from handcart.evaluation.conformance.rig.parts import part_of
from handcart.evaluation.conformance.rig.reach import Reach
from handcart.primitives.contract.action_primitive import Periods
from handcart.primitives.knowledge.world_model import ModelView
from handcart.primitives.restoring.retrace import reach_pose, retrace
from handcart.primitives.restoring.snapshot import Snapshot
from handcart.primitives.restoring.trace import Trace

DELAY_PERIODS = 20  # periods: a quarter of a second for the verdict, then some
UNDO_ERROR_M = 0.005  # [m] that an undo leaves each time


class NotRestored(Reach):
    """Mutant primitive that returns Fail without restoring the robot's state at its start."""

    @override
    def restore(self, robot: Robot, model: ModelView, start: Snapshot, trace: Trace) -> Periods:
        return
        yield


class BaseAlone(Reach):
    """Primitive with a planted fault, by which it restores the base, but not arm and fingers.

    The conformance kit has to find this fault.
    """

    @override
    def restore(self, robot: Robot, model: ModelView, start: Snapshot, trace: Trace) -> Periods:
        yield from reach_pose(robot, start.pose)


class MovesLater(Reach):
    """Mutant primitive that restores the base, and drives off a second later."""

    @override
    def restore(self, robot: Robot, model: ModelView, start: Snapshot, trace: Trace) -> Periods:
        yield from retrace(robot, start, trace)
        backend, periods = robot.backend, [0]
        step = backend.step

        def later() -> None:
            periods[0] += 1
            if periods[0] > DELAY_PERIODS:
                robot.base.drive(0.1, 0.0)
            step()

        backend.step = later  # type: ignore[method-assign]


class RelativeUndo(Reach):
    """Mutant primitive that returns the base to a pose near its start pose, and claims that it is the start
    pose.

    It overwrites the start pose in its snapshot with the pose that it reached.
    """

    @override
    def restore(self, robot: Robot, model: ModelView, start: Snapshot, trace: Trace) -> Periods:
        yield from retrace(robot, start, trace)
        for _ in range(5):
            robot.base.drive(UNDO_ERROR_M / (5 * robot.period), 0.0)
            yield
        object.__setattr__(start, "pose", robot.pose)


class EditsSnapshot(Reach):
    """Mutant primitive that changes its snapshot of the start instead of restoring the robot's state."""

    @override
    def restore(self, robot: Robot, model: ModelView, start: Snapshot, trace: Trace) -> Periods:
        yield from robot.wait(1.0)
        arm, gripper = part_of(robot.backend, Arm), part_of(robot.backend, Gripper)
        if arm is not None:
            start.joints[:] = arm.joints()
        object.__setattr__(start, "pose", robot.pose)
        if gripper is not None:
            object.__setattr__(start, "gripper_width", gripper.width())


class RaisesTolerance(Reach):
    """Mutant primitive that raises the tolerances instead of restoring the robot's state."""

    @override
    def restore(self, robot: Robot, model: ModelView, start: Snapshot, trace: Trace) -> Periods:
        yield from robot.wait(1.0)
        loose = dict.fromkeys(type(robot.spec.tolerance).model_fields, 1000000.0)
        tolerance = robot.spec.tolerance.model_copy(update=loose)
        robot.spec = robot.spec.model_copy(update={"tolerance": tolerance})


class SwallowsFault(Reach):
    """Primitive with a planted fault, by which it ends its motion on every exception and claims success.

    The conformance kit has to find this fault.
    """

    @override
    def motion(self, robot: Robot, model: ModelView) -> Periods:
        try:
            yield from super().motion(robot, model)
        except Exception:
            return

    @override
    def effect(self, robot: Robot, model: ModelView) -> Generator[None, None, bool]:
        return True
        yield


class ClaimsSuccess(Reach):
    """Mutant primitive that does nothing and claims Success."""

    @override
    def motion(self, robot: Robot, model: ModelView) -> Periods:
        yield

    @override
    def effect(self, robot: Robot, model: ModelView) -> Generator[None, None, bool]:
        return True
        yield


class FailsAfterNoReturn(Reach):
    """Mutant primitive that declares a point of no return, but withdraws the declaration after a fault."""

    swing_rad: float = 0.0
    grip_m: float = 0.0

    @override
    def motion(self, robot: Robot, model: ModelView) -> Periods:
        self.point_of_no_return("what is done is done")
        try:
            yield from super().motion(robot, model)
        except BaseException:
            self._no_return = None
            raise


class Hangs(Reach):
    """Primitive with a planted fault, by which its restoring never ends and never yields.

    The conformance kit has to find this fault.
    """

    @override
    def restore(self, robot: Robot, model: ModelView, start: Snapshot, trace: Trace) -> Periods:
        while True:
            pass
        yield


class RunsIntoThings(Reach):
    """Primitive with a planted fault, by which it restores by driving into a wall, past the collision guard.

    The conformance kit has to find this fault.
    """

    @override
    def restore(self, robot: Robot, model: ModelView, start: Snapshot, trace: Trace) -> Periods:
        unguarded = robot.get(Base)  # type: ignore[type-abstract]
        for _ in range(self._far(robot)):
            unguarded.drive(0.3, 0.0)
            yield
            trace.record()
        yield from retrace(robot, start, trace)

    def _far(self, robot: Robot) -> int:
        """Return the number of periods until the base touches the obstacle ahead."""
        scan = robot.range_sensor.scan()
        ahead: Any = np.abs(scan.angles) < 0.1
        return int((float(scan.ranges[ahead].min()) + 0.1) / (0.3 * robot.period))
