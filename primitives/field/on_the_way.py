"""Arm motion while the base drives from one target to the next."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import numpy as np

from handcart.backends.robot.robot import Robot
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy

from .field import Field
from .sensor_arm import SensorArm
from .target import Target

REACH_OUT_DISTANCE_M = 4.5  # of way before the target, from where the arm reaches out: 9 s at full speed
CARRY_HEIGHT_M = 0.25  # of the sensor's foot above the ground while the base still drives


class SensorOnTheWay:
    """Arm motion during a drive, which takes a sensor and brings it over its target before the base arrives.

    The arm stays above the robot's footprint, so that it cannot touch anything that the base would not touch.
    """

    def __init__(self, robot: Robot, field: Field, target: Target) -> None:
        """Create the arm motion for the drive to a target."""
        self._robot, self._field, self._target = robot, field, target

    def motion(self, remaining: Callable[[], float]) -> Iterator[None]:
        """Take a sensor while the base drives, wait until the rest of the route is `REACH_OUT_DISTANCE_M` or
        less, and hold the sensor over the point where it is to be laid.

        Args:
            remaining: function that returns the base's remaining distance, in [m].
        """
        arm, target = SensorArm(self._robot, self._field), self._target
        if not arm.holds:
            yield from arm.stow()
            yield from arm.take()
        while remaining() > REACH_OUT_DISTANCE_M:
            yield
        beside = target.stand.inverse().apply(np.array([[target.x, target.y]])).reshape(2)
        _check_inside(self._robot, arm, beside)
        yield from arm.reach(arm.place_beside(beside))
        yield from arm.slide(max(arm.scara.slide[0], arm.scara.mount[2] - arm.below - CARRY_HEIGHT_M))


def _check_inside(robot: Robot, arm: SensorArm, beside: np.ndarray) -> None:
    """Raise `Discrepancy` if arm or sensor would leave the footprint with the tip at `beside` (2,), in the
    base frame in [m].
    """
    elbow = math.hypot(*arm.scara.mount[:2]) + arm.scara.upper
    out = max(elbow, float(np.hypot(*beside)) + arm.wide)
    if out > robot.spec.footprint_radius_m:
        raise Discrepancy(
            f"over its target the sensor extends {out:.2f} m, beyond the footprint",
            permanent=True,
            cause=causes.OUT_OF_REACH,
        )
