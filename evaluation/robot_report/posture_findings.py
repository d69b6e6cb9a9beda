"""Check of a robot's named postures for self-collisions and for parts beyond its footprint."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from typing import NamedTuple

import numpy as np

from handcart.backends.description.robot_file import RobotFile
from handcart.backends.description.robot_names import robot_path
from handcart.files.errors import Finding
from handcart.files.stages import begin_stage
from handcart.files.suggest import listed
from handcart.files.yaml.yaml_document import read_document
from handcart.robotics.geometry.footprint import Footprint
from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.manipulation.motions.collision_model import CollisionModel
from handcart.robotics.numerics.arrays import FloatArray

from .masses import corners_of

FINGER_JOINTS = ("left_finger", "right_finger")
TRAVEL_POSTURES = ("home", "carry")  # in which primitives leave the arm before the base drives
ROUNDING_M = 1e-3


class PostureFacts(NamedTuple):
    """Facts about the robot in a named posture, such as self-contacts and the space that the arm needs."""

    name: str
    touching: tuple[tuple[str, str], ...]
    """Pairs of links that touch."""
    reach: float
    """Largest distance of the arm from the base's axis, in [m]."""
    farthest: str
    """Link with that distance."""
    outside: float
    """Largest distance of the arm beyond the footprint, in [m]; negative inside."""
    travels: bool
    """True if the base drives in this posture."""


def posture_facts(robot: RobotFile) -> list[PostureFacts]:
    """Return self-contacts, reach and more facts of each posture in a robot's file; empty without an arm."""
    if robot.arm is None:
        return []
    arm = opened_arm(robot)
    collision = CollisionModel(arm)
    moved = moved_links(arm)
    shape = robot.footprint_shape
    return [
        _facts(name, np.array(robot.posture(name)), arm, collision, moved, shape)
        for name in robot.arm.postures
    ]


def posture_findings(robot_name: str, robot: RobotFile) -> Iterator[Finding]:
    """Yield findings, at lines of the robot's file, about postures in which the robot touches itself, or in
    which the base drives although the arm is outside the footprint.

    Args:
        robot_name: name of a shipped robot, or path of its file.
        robot: the robot's file.
    """
    begin_stage("postures of the arm")
    facts = posture_facts(robot)
    if not facts:
        return
    document = read_document(robot_path(robot_name))
    for fact in facts:
        key = ("arm", "postures", fact.name)
        if fact.touching:
            pairs = listed(f"{one} with {other}" for one, other in fact.touching)
            yield document.finding(key, f"in posture {fact.name!r} the robot touches itself: {pairs}")
        if fact.travels and fact.outside > ROUNDING_M:
            wrong = f"the base drives in posture {fact.name!r}, and {fact.farthest} is {fact.reach:.3f} m"
            allowed = f"from its middle; allowed: within the footprint, {robot.footprint_radius_m:g} m"
            if not robot.footprint_shape.is_disc:
                wrong = f"the base drives in posture {fact.name!r}, and the arm is {fact.outside:.3f} m"
                allowed = "outside the footprint; allowed: within it"
            yield document.finding(key, f"{wrong} {allowed}")


def opened_arm(robot: RobotFile) -> ArmModel:
    """Return the robot's arm with open fingers."""
    arm = robot.arm_model()
    if robot.gripper is None:
        return arm
    try:
        return arm.with_others(dict.fromkeys(FINGER_JOINTS, robot.gripper.opening_mm / 2e3))
    except ValueError:  # other finger joints, or none
        return arm


def moved_links(arm: ArmModel) -> set[str]:
    """Return the links with collision bodies that the arm's joints move."""
    here = 0.5 * (arm.lower + arm.upper)
    names = [shape.name for shape in arm.link_shapes(here)]
    poses = zip(names, arm.link_poses(here), arm.link_poses(here + 0.1), strict=True)
    return {name for name, one, other in poses if not np.allclose(one, other)}


def _facts(
    name: str,
    joints: FloatArray,
    arm: ArmModel,
    collision: CollisionModel,
    moved: Collection[str],
    footprint: Footprint,
) -> PostureFacts:
    shapes = [shape for shape in arm.link_shapes(joints) if shape.name in moved]
    out = {shape.name: 0.0 for shape in shapes}
    for shape in shapes:
        out[shape.name] = max(out[shape.name], float(np.hypot(*corners_of(shape)[:, :2].T).max()))
    spots = np.vstack([np.zeros((1, 2)), *(corners_of(shape)[:, :2] for shape in shapes)])
    outside = float(footprint.distances(spots).max())
    farthest = max(out, key=lambda link: out[link], default="")
    touching = tuple(collision.contacts(joints))
    return PostureFacts(name, touching, out.get(farthest, 0.0), farthest, outside, name in TRAVEL_POSTURES)
