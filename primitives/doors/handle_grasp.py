"""Posture of the arm with which a hand takes a handle and can follow it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from handcart.backends.robot.robot import Robot
from handcart.robotics.geometry.transform import Transform, inverse, transform
from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.kinematics.shapes import Solid
from handcart.robotics.manipulation.doors.door_joint import DoorJoint
from handcart.robotics.manipulation.motions.collision_model import ARM_MARGIN_M, HELD_NAME, CollisionModel
from handcart.robotics.manipulation.motions.motion_planner import plan_straight
from handcart.robotics.numerics.arrays import FloatArray

from .doors_file import KnownDoor

APPROACH_M = 0.09  # before the handle, where the hand lines up
GRIP_DEPTH_M = 0.018  # from the finger tips to the middle of the bar
AZIMUTHS_DEG = (0.0, 15.0, -15.0, 30.0, -30.0)
"""Turns of the hand about a vertical bar."""
IK_RESTARTS = 8
POSTURES_PER_GRASP = 4
STEP_M = 0.03  # along the believed path
MAX_LEAP_RAD = 0.35  # of a joint in such a step
MIN_LEVER_M = 0.12
"""Least motion of the hand, in [m], by a turn of 1 rad of the joint that turns most; with less, a joint is
too far from its command before the hand pulls.
"""
GOOD_LEVER_M = 0.35
DAMPING = 1e-6
STRAIGHT_STEP_M = 0.01
FRAME_GAP_M = 0.02  # between a front and what it is built into


class PlannedHandle(NamedTuple):
    """Planned grasp of a door's handle, with the share of the handle's path that the arm can follow."""

    before: FloatArray
    """(n,) joints where the hand lines up, in [rad] or [m]."""
    base_T_grip: Transform
    """Pose (4, 4) of the hand around the bar, in the base frame."""
    reach: float
    """Share of the believed path of the handle that the arm can follow, 0 to 1."""
    lever: float
    """Least way of the hand along the path by a turn of 1 rad of the joint that turns most, in [m]."""


def plan_handle(
    robot: Robot,
    door: KnownDoor,
    base_T_handle: Transform,
    joint: DoorJoint,
    openings: Sequence[float],
    front: Solid,
    around: Sequence[Solid],
) -> PlannedHandle | None:
    """Return the grasp with which the hand can move the handle the farthest; None if there is none.

    On the path of the handle, and as the hand withdraws at its end, the arm touches neither obstacles nor the
    robot nor the front, and the front touches neither the robot nor obstacles. The front is not checked
    against what it is within `FRAME_GAP_M` of, now or closed, such as the frame around it.

    Args:
        robot: robot with an arm and a gripper.
        door: the door.
        base_T_handle: (4, 4) measured pose of the handle.
        joint: assumed hinge or slide of the door, in the base frame.
        openings: assumed present opening, and wanted one, in [rad] if hinged, in [m] if sliding.
        front: front of the door, in the base frame.
        around: other obstacles for the arm, in the base frame.
    """
    spec = robot.spec.gripper
    half = (spec.opening_mm if spec is not None else 0.0) / 2e3
    arm = robot.arm_model.with_others({"left_finger": half, "right_finger": half})
    collision = CollisionModel(arm, (*around, front), margin=ARM_MARGIN_M)
    from_now = np.linalg.inv(joint.displaced(openings[0]))
    moved = front.seen_from(np.asarray(joint.displaced(openings[1]) @ from_now))
    at_end = CollisionModel(arm, (*around, moved), margin=ARM_MARGIN_M)
    closed = front.seen_from(np.asarray(joint.displaced(0.0) @ from_now))
    frame = frozenset[str]().union(*(collision.obstacles_near(at, FRAME_GAP_M) for at in (front, closed)))
    here, best = robot.arm.command(), None
    for handle_T_hand in hand_poses(door, robot.spec.finger_shape.tip):
        grip = np.asarray(base_T_handle @ handle_T_hand)
        ahead = np.asarray(grip @ transform((-APPROACH_M, 0.0, 0.0)))
        checks = _moving_front(arm, around, front, grip, frame), at_end
        for number, before in enumerate(arm.solutions(ahead, here, restarts=IK_RESTARTS)):
            if number == POSTURES_PER_GRASP:
                break
            if collision.in_collision(before):
                continue
            line = plan_straight(arm, before, grip, STRAIGHT_STEP_M, collision)
            if line is None:
                continue
            found = PlannedHandle(before, grip, *_followed(checks, line[-1], grip, joint, openings))
            if best is None or (found.reach, found.lever) > (best.reach, best.lever):
                best = found
        if best is not None and best.reach == 1.0 and best.lever > GOOD_LEVER_M:
            break
    return best


def hand_poses(door: KnownDoor, tip: float) -> Iterator[Transform]:
    """Yield handle_T_hand (4, 4) of hands that point at the door with the bar between their fingers.

    Args:
        door: the door.
        tip: distance from the frame of the hand to the finger tips, in [m].
    """
    upright = door.handle.bar == "vertical"
    for azimuth in AZIMUTHS_DEG if upright else (0.0,):
        for flip in (1.0, -1.0):
            pose = np.eye(4)
            pose[:3, 0] = (-1.0, 0.0, 0.0)
            pose[:3, 1] = (0.0, -flip, 0.0) if upright else (0.0, 0.0, flip)
            pose[:3, 2] = np.cross(pose[:3, 0], pose[:3, 1])
            pose[0, 3] = tip - GRIP_DEPTH_M
            yield np.asarray(transform(rpy=(0.0, 0.0, math.radians(azimuth))) @ pose)


def _moving_front(
    arm: ArmModel, around: Sequence[Solid], front: Solid, base_T_grip: Transform, frame: frozenset[str]
) -> CollisionModel:
    """Return a model of the arm with a door's front that moves along with the hand on its handle.

    Args:
        arm: the arm.
        around: obstacles in the base frame.
        front: front of the door, in the base frame, where the hand takes the handle.
        base_T_grip: (4, 4) pose of the hand there.
        frame: names of the obstacles that the front may touch.
    """
    carried = front.seen_from(inverse(base_T_grip))
    allowed = [(HELD_NAME, name) for name in sorted(frame)]
    return CollisionModel(arm, around, carried, margin=ARM_MARGIN_M, allowed=allowed)


def _followed(
    checks: tuple[CollisionModel, CollisionModel],
    joints: FloatArray,
    grip: Transform,
    joint: DoorJoint,
    openings: Sequence[float],
) -> tuple[float, float]:
    """Return the share (0 to 1) of the path that a posture can follow, and the least lever on it.

    The lever is the motion of the hand, in [m], by a turn of 1 rad of the joint that turns most.

    Args:
        checks: arm of the robot with the door's front in its hand, for the path; and among obstacles and the
            front at the path's end, for the withdrawal.
        joints: (n,) posture at the begin of the path, in [rad] or [m].
        grip: (4, 4) base_T_hand at the begin.
        joint: believed joint of the door, in the base frame.
        openings: opening at the begin and at the end, in [rad] or [m].
    """
    (begin, end), (collision, at_end) = openings, checks
    arm = collision.arm
    from_now = np.linalg.inv(joint.displaced(begin))
    count = max(1, math.ceil(abs(joint.travel(end - begin)) / STEP_M))
    least = _lever(arm, joints, joint, begin)
    for number in range(1, count + 1):
        opening = begin + (end - begin) * number / count
        found = arm.inverse(np.asarray(joint.displaced(opening) @ from_now @ grip), joints, restarts=0)
        if found is None or float(np.abs(found - joints).max()) > MAX_LEAP_RAD:
            return (number - 1) / count, least
        if collision.in_collision(found):
            return (number - 1) / count, least
        if (lever := _lever(arm, found, joint, opening)) < MIN_LEVER_M:
            return (number - 1) / count, least
        joints, least = found, min(least, lever)
    back = arm.forward(joints) @ transform((-APPROACH_M, 0.0, 0.0))
    line = plan_straight(arm, joints, np.asarray(back), STRAIGHT_STEP_M, at_end)
    return 1.0 if line is not None else (count - 1) / count, least


def _lever(arm: ArmModel, joints: FloatArray, joint: DoorJoint, opening: float) -> float:
    heading = joint.heading(opening)
    J, way = arm.jacobian(joints), np.array([math.cos(heading), math.sin(heading), 0.0, 0.0, 0.0, 0.0])
    rates = J.T @ np.linalg.solve(J @ J.T + DAMPING * np.eye(6), way)
    return 1.0 / float(np.abs(rates).max())
