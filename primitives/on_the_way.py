"""What the arm does while the base drives from one target to the next."""

from __future__ import annotations

import math

import numpy as np

from handcart.backends.robot import Robot
from handcart.robotics.navigation.car_tracker import CarTracker
from handcart.robotics.navigation.path_tracking import PathTracker

from .action_primitive import Periods
from .discrepancy import Discrepancy
from .sensor_arm import SensorArm
from .world_model import ModelView

AHEAD = 4.5  # [m] of way before the target, from where the arm reaches out: 9 s at full speed
LOW = 0.25  # [m] of the sensor's foot above the ground while the base still drives


def arm_on_the_way(robot: Robot, model: ModelView, place: str, tracker: PathTracker | CarTracker) -> Periods:
    """Bring the arm home, take a sensor, and near its target hold it over where that will be, low.

    One period of it for each of the base's. All of it stays over the footprint, so nothing is met that the
    base wouldn't meet.

    Args:
        robot: its base is on the way.
        model: the field and its targets.
        place: the target's name.
        tracker: tells what is left of the way.

    Raises:
        Discrepancy: there is no such target, no sensor, or the arm doesn't get there.
    """
    if model.field is None or place not in model.targets:
        raise Discrepancy(f"there is no target {place!r} in the field", permanent=True)
    arm, target = SensorArm(robot, model.field), model.targets[place]
    if not arm.holds:
        yield from arm.stow()
        yield from arm.take()
    while tracker.remaining > AHEAD:
        yield
    beside = target.stand.inverse().apply(np.array([[target.x, target.y]])).reshape(2)
    _check_inside(robot, arm, beside)
    yield from arm.reach(arm.place_beside(beside))
    yield from arm.slide(max(arm.scara.slide[0], arm.scara.mount[2] - arm.below - LOW))


def _check_inside(robot: Robot, arm: SensorArm, beside: np.ndarray) -> None:
    """Raise `Discrepancy` where arm or sensor would stand out over the footprint at a place (2,) beside."""
    elbow = math.hypot(*arm.scara.mount[:2]) + arm.scara.upper
    out = max(elbow, float(np.hypot(*beside)) + arm.wide)
    if out > robot.spec.footprint_radius_m:
        raise Discrepancy(
            f"over its target the sensor stands out {out:.2f} m, beyond the footprint", permanent=True
        )
