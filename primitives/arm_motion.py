"""Motions of the arm: to postures and poses, around what stands in the way."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from backends.robot import Robot
from robotics.geometry.transform import Transform, transform
from robotics.kinematics.shapes import Box, Shape
from robotics.manipulation.collision_model import HELD, CollisionModel
from robotics.manipulation.motion_planner import plan_motion
from robotics.manipulation.trajectory import time_path

from .action_primitive import Periods
from .discrepancy import Discrepancy
from .grip import GRIP_HEIGHT, HAND_TO_SPINE
from .knowledge import Book

MARGIN = 0.005  # [m] between the arm and anything
ALLOWED = ((HELD, "tray"),)  # what the hand holds was taken from there

Vector = NDArray[np.float64]


def move_to_posture(
    robot: Robot, name: str, held: Shape | None = None, around: Sequence[Shape] = ()
) -> Periods:
    """Move to a named posture of the robot's file. Arguments and errors as for `move_to_joints`."""
    yield from move_to_joints(robot, np.array(robot.spec.posture(name)), held, around)


def move_to_pose(
    robot: Robot, base_T_hand: Transform, held: Shape | None = None, around: Sequence[Shape] = ()
) -> Periods:
    """Move the hand to a pose (4, 4). Arguments and errors as for `move_to_joints`."""
    joints = robot.arm_model.inverse(base_T_hand, near=robot.arm.command())
    if joints is None:
        x, y, z = base_T_hand[:3, 3]
        raise Discrepancy(f"the arm doesn't reach ({x:.2f}, {y:.2f}, {z:.2f}) m")
    yield from move_to_joints(robot, joints, held, around)


def move_to_joints(
    robot: Robot, joints: Vector, held: Shape | None = None, around: Sequence[Shape] = ()
) -> Periods:
    """Move to joint angles (n,) in [rad], free of collisions with the robot and what it knows of.

    Args:
        robot: the arm holds where it was last commanded.
        joints: where to.
        held: what the hand holds, posed in the hand frame.
        around: bodies to keep clear of, posed in the base frame.

    Raises:
        Discrepancy: no free way was found.
    """
    here = robot.arm.command()
    if np.allclose(here, joints, atol=1e-4):
        return
    width = robot.gripper.command() / 2.0
    arm = robot.arm_model.with_others({"left_finger": width, "right_finger": width})
    collision = CollisionModel(arm, around, held, margin=MARGIN, allowed=ALLOWED)
    path = yield from robot.compute(plan_motion, arm, collision, here, joints)
    if path is None:
        hits = collision.contacts(joints) or collision.contacts(here)
        raise Discrepancy(f"the arm finds no free way{_between(hits)}")
    yield from follow(robot, path)


def follow(robot: Robot, path: NDArray[np.float64]) -> Periods:
    """Move along straight joint lines (m, n) in [rad], from where the arm was last commanded."""
    spec = robot.spec.arm
    top = np.radians(spec.top_speed_deg_s) if spec else np.inf
    hard = np.radians(spec.acceleration_deg_s2) if spec else np.inf
    speed = np.minimum(robot.arm_model.velocity, top)
    for joints in time_path(path, speed, np.full(len(speed), hard), robot.period)[1:]:
        robot.arm.move(joints)
        yield


def held_box(book: Book) -> Box:
    """A book as PICK_UP grips it, posed in the hand frame."""
    depth, thickness, height = (1e-3 * size for size in (book.depth_mm, book.thickness_mm, book.height_mm))
    middle = transform((HAND_TO_SPINE + depth / 2, 0.0, height / 2 - GRIP_HEIGHT))
    return Box(middle, (depth, thickness, height), HELD)


def _between(hits: Sequence[tuple[str, str]]) -> str:
    return f": {hits[0][0]} would touch {hits[0][1]}" if hits else ""
