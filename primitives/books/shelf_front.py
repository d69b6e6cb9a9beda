"""Pose of the shelf in front of the docked robot."""

from __future__ import annotations

from collections.abc import Generator

import numpy as np

from handcart.backends.robot.robot import Robot
from handcart.primitives.knowledge.place import Place
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy, Measured
from handcart.robotics.geometry.transform import Transform, inverse
from handcart.robotics.navigation.scans.front_line import fit_front, pose_from_front

FRONT_SCANS = 20  # stacked for one measurement: 10 mm of noise become 0.5 mm of distance
FRONT_GATE_M = 0.10  # that the front may be off where map and pose have it


def measure_shelf(robot: Robot, place: Place) -> Generator[None, None, Transform]:
    """Measure base_T_shelf (4, 4) from a base at rest before the shelf.

    The shelf's frame has x into the shelf, y to the left and z up; its origin is the middle of the front edge
    at the height of the board. Distance and angle are measured on the shelf's front; the position along the
    front is that of the localizer.

    Args:
        robot: robot before the shelf, at rest.
        place: docking place of the shelf.

    Raises:
        Discrepancy: no front is seen where it should be, or the place has no shelf.
    """
    if place.shelf is None:
        raise Discrepancy("no shelf is at this place", permanent=True, cause=causes.NOT_KNOWN)
    scans = []
    for _ in range(FRONT_SCANS):
        yield
        scans.append(robot.range_sensor.scan().points())
    front = fit_front(np.vstack(scans), robot.pose.inverse().apply(place.front), gate=FRONT_GATE_M)
    if front is None:
        unseen = Measured(
            "RangeSensor", "a straight front where the shelf should be", None, FRONT_GATE_M, "m"
        )
        raise Discrepancy(
            "the front of the shelf is not seen where it should be", measured=unseen, cause=causes.NOT_SEEN
        )
    map_T_base = pose_from_front(robot.pose, front, place.front)
    return inverse(map_T_base.lift()) @ place.map_T_shelf
