"""REACH: a correct primitive that moves every actuator, used by the kit."""

from __future__ import annotations

import math
from collections.abc import Generator
from typing import Any, ClassVar

import numpy as np
from pydantic import PrivateAttr
from typing_extensions import override

from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.base import Base
from handcart.backends.capabilities.gripper import Gripper
from handcart.backends.ground_truth import GroundTruth
from handcart.backends.robot.robot import Robot
from handcart.primitives.contract.action_primitive import ActionPrimitive, Periods
from handcart.primitives.knowledge.world_model import ModelView
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy

from .parts import part_of
from .periods import beside, drivable

SPEED, CREEP, SWINGS = 0.2, 0.02, 0.3  # [m/s], [m/s], [rad/s]
NEGLIGIBLE_M = 0.002  # [m] left that count as nothing
MIN_REACHED_RATIO = 0.8  # of what was to be reached that must be
FINGER_TIMEOUT_S = 3.0  # [s] that the fingers get


class Reach(ActionPrimitive):
    """Primitive for tests that drives ahead, turns the first joint and closes the fingers partly.

    Parts that the robot lacks are not moved.
    """

    ahead_m: float = 0.15
    """Distance to drive."""
    swing_rad: float = 0.15
    """Turn of the first joint."""
    grip_m: float = 0.01
    """Distance to close the fingers."""
    fails: bool = False
    """True to raise a Discrepancy at the end."""

    needs: ClassVar = (Base,)

    _pose: Any = PrivateAttr(default=None)

    @override
    def motion(self, robot: Robot, model: ModelView) -> Periods:
        self._pose = robot.pose
        yield from self._drive(robot)
        yield from self._swing(robot)
        yield from self._grip(robot)
        if self.fails:
            raise Discrepancy("it was only to be tried", cause=causes.CANCELLED)

    def _drive(self, robot: Robot) -> Periods:
        """Drive ahead by `ahead_m`, within the robot's limit of acceleration."""
        left, speed, rate = self.ahead_m, 0.0, robot.drive_limits.acceleration
        top, _ = drivable(robot.spec, SPEED, 0.0)
        while left > NEGLIGIBLE_M:
            speed = min(top, speed + rate * robot.period, max(CREEP, math.sqrt(rate * left)))
            robot.base.drive(speed, 0.0)
            left -= speed * robot.period
            yield

    def _swing(self, robot: Robot) -> Periods:
        arm = part_of(robot.backend, Arm)
        if arm is None:
            return
        start = arm.command()
        way = beside(robot.spec, start, 0, self.swing_rad) - start
        for share in np.linspace(0.0, 1.0, round(self.swing_rad / (SWINGS * robot.period)) + 1)[1:]:
            arm.move(start + share * way)
            yield

    def _grip(self, robot: Robot) -> Periods:
        gripper = part_of(robot.backend, Gripper)
        if gripper is None:
            return
        goal = max(0.0, gripper.command() - self.grip_m)
        gripper.move(goal)
        end = robot.time + FINGER_TIMEOUT_S
        while abs(gripper.width() - goal) > 5e-4 and not gripper.closed_on_something():
            if robot.time > end:
                raise Discrepancy("the fingers don't close", cause=causes.FINGERS_STUCK)
            yield

    def effect(self, robot: Robot, model: ModelView) -> Generator[None, None, bool]:
        """Return whether the base has gone `MIN_REACHED_RATIO` of `ahead_m`, by its estimated pose."""
        return (
            self._pose is not None and robot.pose.relative_to(self._pose).x > MIN_REACHED_RATIO * self.ahead_m
        )
        yield

    def false_effect(self, scene: Any, before: GroundTruth) -> list[str]:
        """Return a message if the base moved ahead too little despite Success, otherwise an empty list.

        Args:
            scene: the simulated world after the Success.
            before: ground truth at the start of the primitive.
        """
        went = scene.base.relative_to(before.base).x
        least = MIN_REACHED_RATIO * self.ahead_m - 0.02  # error of the pose's estimate
        return [] if went > least else [f"the base went {went:.3f} m of {self.ahead_m} m"]
