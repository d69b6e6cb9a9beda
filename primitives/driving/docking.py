"""Docking of a base in front of an object with a straight front."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from handcart.backends.robot.localization.determination import (
    DETERMINED_SIGMAS,
    NO_SHIFT,
    PoseNeed,
    difference,
    undetermined,
)
from handcart.backends.robot.robot import Robot
from handcart.primitives.contract.action_primitive import Periods
from handcart.primitives.knowledge.place import Place
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy, Measured
from handcart.primitives.restoring.retrace import reach_pose
from handcart.primitives.restoring.snapshot import settle
from handcart.robotics.navigation.following.pose_regulator import PoseTolerance
from handcart.robotics.navigation.scans.front_line import FrontLine, fit_front, pose_from_front

DOCK_TOLERANCE = PoseTolerance(position=0.004, heading=0.003)
DOCK_MAX_TRIES = 4  # times that the front is measured and the pose corrected
FRONT_SCANS = 20  # scans stacked for one measurement of the front
NOT_DETERMINED = "not determined"  # the check that found a pose to be uncertain


def dock(robot: Robot, name: str, place: Place, need: PoseNeed, report: Callable[..., None]) -> Periods:
    """Drive the base to its pose square in front of an object, by measuring the object's straight front.

    Args:
        robot: the robot, near the place.
        name: name of the place in messages.
        place: a place in front of an object with a straight front.
        need: required accuracy of the pose.
        report: function that receives the metric `dock_mm` of each measurement, the distance of the base from
            its place in [mm].

    Raises:
        Discrepancy: the front is not seen, does not determine the pose, or the base does not come to
            rest square in front of it.
    """
    for _ in range(DOCK_MAX_TRIES):
        yield from settle(robot)
        scans = []
        for _ in range(FRONT_SCANS):
            scans.append(robot.range_sensor.scan().points())
            yield
        expected = robot.pose.inverse().apply(place.front)
        front = fit_front(np.vstack(scans), expected, gate=0.15)
        if front is None:
            unseen = Measured("RangeSensor", "a straight front where the map has one")
            raise Discrepancy(f"the front before {name} is not seen", measured=unseen, cause=causes.NOT_SEEN)
        seen = pose_from_front(robot.pose, front, place.front)
        report(dock_mm=round(1e3 * seen.distance(place.pose), 1))
        if (
            seen.distance(place.pose) < DOCK_TOLERANCE.position
            and seen.turn(place.pose) < DOCK_TOLERANCE.heading
        ):
            check_front(front, name, need)
            return
        yield from reach_pose(robot, robot.pose.compose(place.pose.relative_to(seen)), DOCK_TOLERANCE)
    off = Measured(
        "RangeSensor",
        "off its place",
        1e3 * seen.distance(place.pose),
        1e3 * DOCK_TOLERANCE.position,
        "mm",
    )
    raise Discrepancy(
        f"the base doesn't come to rest square before {name}", measured=off, cause=causes.OFF_GOAL
    )


def check_front(front: FrontLine, name: str, need: PoseNeed) -> None:
    """Raise `Discrepancy` if 3 sigma of the measured front of an object exceed the required pose accuracy.

    Args:
        front: measured front.
        name: name of the place in messages.
        need: required accuracy of the pose.
    """
    sizes = (
        1e3 * DETERMINED_SIGMAS * front.distance_std,
        math.degrees(DETERMINED_SIGMAS * front.angle_std),
    )
    limits = 1e3 * need.position, math.degrees(need.heading)
    for size, limit, unit in zip(sizes, limits, ("mm", "deg"), strict=True):
        if not size <= limit:
            measured = Measured("RangeSensor", "3 sigma of the front", size, limit, unit)
            why = f"not determined: the front before {name} is measured to {size:.1f} {unit}"
            raise Discrepancy(
                f"{why}, at most {limit:.1f} {unit} allowed",
                True,
                measured,
                NOT_DETERMINED,
                cause=causes.UNDETERMINED,
            )


def check_determined(robot: Robot, name: str, place: Place, need: PoseNeed) -> None:
    """Raise `Discrepancy` if the sensors don't determine the pose of the robot's base at a place accurately
    enough.

    Args:
        robot: robot at the place.
        name: name of the place in messages.
        place: the place.
        need: required accuracy of the pose.
    """
    off, shift = difference(robot.pose, place.pose), robot.localization.map_shift
    if place.docks:  # its front was measured, not the map
        off, shift = (0.0, 0.0, 0.0), NO_SHIFT
    found = undetermined(robot.localization.repeatability, need, off, shift)
    if found is None:
        return
    size, limit = found.shown
    measured = Measured(robot.localization.source, "3 sigma of the pose", size, limit, found.unit)
    raise Discrepancy(
        f"not determined: at {name} {found.words}",
        True,
        measured,
        NOT_DETERMINED,
        cause=causes.UNDETERMINED,
    )
