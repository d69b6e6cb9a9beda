"""True openings and hinges of doors, and the errors of the hinges that primitives found."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from handcart.backends.simulation.doors.door_part import HANDLE, DoorPart
from handcart.backends.simulation.doors.door_props import DoorProps
from handcart.evaluation.judging.survey import Survey
from handcart.primitives.contract.action_primitive import ActionPrimitive
from handcart.robotics.geometry.transform import inverse
from handcart.robotics.manipulation.doors.door_joint import DoorJoint


class HingeErrors(NamedTuple):
    """Errors of a door's measured hinge in position and direction of the axis, and in the radius."""

    place_mm: float
    """Distance between true and found axis at the height of the handle, in the base frame."""
    axis_deg: float
    radius_mm: float


def door_of(survey: Survey, name: str) -> DoorPart | None:
    """Return a door's handle as a body of the simulated world; None if no door has that name."""
    return survey.run.world.of(DoorProps).parts.get(f"{HANDLE} {name}")


def true_opening(survey: Survey, name: str) -> float:
    """Return the true opening of a simulated door, in [rad] if it is hinged, in [m] if it slides."""
    return survey.run.world.of(DoorProps).openings[name]


def hinge_errors(survey: Survey, primitive: ActionPrimitive, joint: DoorJoint) -> HingeErrors | None:
    """Return the errors of the hinge that a primitive found; None if it found none, or the door slides.

    Args:
        survey: survey with the simulated world.
        primitive: primitive that has ended.
        joint: true joint of the door, in the world.
    """
    facts = primitive.facts
    if joint.hinge is None or "hinge_x_m" not in facts:
        return None
    there = joint.closed @ (*joint.hinge, 0.0, 1.0)
    x, y, z = (inverse(survey.run.world.world_T_base) @ there)[:3].tolist()
    found = [float(facts[key]) for key in ("hinge_x_m", "hinge_y_m", "hinge_z_m")]
    tilt = np.array([float(facts["axis_x"]), float(facts["axis_y"])])
    # The axis is upright: at the height of the handle the found one is aside by its tilt.
    off = np.array([found[0] - x, found[1] - y]) + tilt * (z - found[2])
    return HingeErrors(
        1e3 * float(np.hypot(*off)),
        math.degrees(math.asin(min(1.0, float(np.hypot(*tilt))))),
        abs(float(facts["radius_mm"]) - 1e3 * joint.radius),
    )
