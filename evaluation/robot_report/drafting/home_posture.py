"""Search of a first posture for driving: without self-collision, near the base's axis, above the floor."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from handcart.backends.description.joint_units import JointUnits
from handcart.evaluation.robot_report.masses import corners_of
from handcart.evaluation.robot_report.posture_findings import moved_links
from handcart.evaluation.robot_report.self_contact import Pair, self_contact
from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.kinematics.shapes import Shape
from handcart.robotics.kinematics.urdf_contents import JointFacts, bodies_of
from handcart.robotics.kinematics.urdf_frames import link_poses
from handcart.robotics.manipulation.motions.collision_model import CollisionModel
from handcart.robotics.numerics.arrays import FloatArray

RANDOM_POSTURES = 300
MIN_HEIGHT_M = -1e-3  # rounding, relative to the floor
POSTURE_DIGITS = 1  # of a posture in the draft, in [deg] or [mm]


class Home(NamedTuple):
    """Posture of the arm proposed for driving, with the radius that contains the robot in it, and the pairs
    of links that touch in every posture.
    """

    posture: Sequence[float]
    """Joint positions in [deg], or [mm] for prismatic joints."""
    is_free: bool
    """True if the posture is without self-collision and above the floor."""
    always: Sequence[Pair]
    """Pairs of links that touch in every posture."""
    radius: float
    """Radius of the circle around the base's axis that contains all collision bodies, in [m]; 0 without
    bodies.
    """
    farthest: str
    """Link that is farthest from the base's axis; empty without bodies."""


def home_of(urdf_text: str, base: str, hand: str, joints: Sequence[JointFacts], units: JointUnits) -> Home:
    """Search a posture of the arm for driving: near the base's vertical axis and free of collisions.

    If no posture is free, the result is the posture in the middle of the joints' travels, and `is_free` is
    False.

    Args:
        urdf_text: a valid URDF.
        base: link on the floor.
        hand: link at the arm's end.
        joints: the arm's joints, with type and limits.
        units: units of the joints.
    """
    arm = ArmModel(urdf_text, units.names, tip=hand, base=base)
    always = self_contact(arm).always
    free = CollisionModel(arm, allowed=always)
    moved = moved_links(arm)
    middle = np.array([middle_of(joint) for joint in joints])
    drawn = np.random.default_rng(0).uniform(arm.lower, arm.upper, (RANDOM_POSTURES, arm.dof))
    best, extent = None, math.inf
    for q in (middle, *drawn):
        rounded = np.array(units.si(_rounded(units, q)))
        own = [shape for shape in arm.link_shapes(rounded) if shape.name in moved]
        out = _farthest(own)[0]
        if out < extent and _lowest(own) > MIN_HEIGHT_M and not free.in_collision(rounded):
            best, extent = rounded, out
    chosen = middle if best is None else best
    radius, farthest = _farthest(arm.link_shapes(chosen))
    return Home(_rounded(units, chosen), best is not None, always, radius, farthest)


def radius_of(urdf_text: str, base: str) -> float:
    """Return the radius around a link's z axis that contains all bodies with the joints at zero, in [m].

    It is 0 without bodies.
    """
    poses = link_poses(urdf_text)
    base_T_root = np.linalg.inv(poses[base])
    corners = [_placed(base_T_root @ poses[item.name], corners_of(item)) for item in bodies_of(urdf_text)]
    return float(np.hypot(*np.vstack(corners)[:, :2].T).max()) if corners else 0.0


def middle_of(joint: JointFacts) -> float:
    """Return a middle position of a joint, in [rad] or [m]: 0 if within the limits, otherwise their mean."""
    if joint.kind == "continuous" or joint.lower is None or joint.upper is None:
        return 0.0
    return 0.0 if joint.lower <= 0.0 <= joint.upper else 0.5 * (joint.lower + joint.upper)


def _rounded(units: JointUnits, q: FloatArray) -> list[float]:
    """Return joint positions (n,) in [deg] or [mm], rounded towards zero so that no limit is exceeded; `q` is
    in [rad] or [m].
    """
    scale = 10.0**POSTURE_DIGITS
    return [float(item) + 0.0 for item in np.trunc(np.array(units.user_units(q.tolist())) * scale) / scale]


def _farthest(shapes: Sequence[Shape]) -> tuple[float, str]:
    """Return the largest distance of a body from the z axis in [m], and its name."""
    out = ((float(np.hypot(*corners_of(shape)[:, :2].T).max()), shape.name) for shape in shapes)
    return max(out, default=(0.0, ""))


def _lowest(shapes: Sequence[Shape]) -> float:
    return min((float(corners_of(shape)[:, 2].min()) for shape in shapes), default=0.0)


def _placed(pose: FloatArray, points: FloatArray) -> FloatArray:
    return np.asarray(points @ pose[:3, :3].T + pose[:3, 3])
