"""Motions of the arm to postures and poses, around obstacles."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from handcart.backends.capabilities.gripper import Gripper
from handcart.backends.robot.robot import Robot
from handcart.primitives.contract.action_primitive import Periods
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy, Measured
from handcart.robotics.geometry.transform import Transform
from handcart.robotics.kinematics.shapes import Shape
from handcart.robotics.manipulation.motions.collision_model import ARM_MARGIN_M, HELD_NAME, CollisionModel
from handcart.robotics.manipulation.motions.motion_planner import LIMIT_ROUNDING, plan_motion, plan_straight
from handcart.robotics.manipulation.motions.trajectory import time_path
from handcart.robotics.numerics.arrays import FloatArray

ALLOWED_CONTACTS = ((HELD_NAME, "tray"),)  # a held object was taken from the tray
FINGER_RESOLUTION_M = 5e-4  # to which fingers are known, so that one model serves for many motions
MAX_JOINT_LAG_RAD = 0.15  # behind the command at which something stops the arm: two periods at top speed
MAX_SLIDE_LAG_M = 0.03  # the same of joints that slide
GOAL_TOLERANCE_RAD = 1e-4  # to a goal that needs no motion
MORE_STARTS = 40  # of the inverse kinematics, where its first posture can't be reached
MORE_GOALS = 3  # postures that a way is looked for to then


def move_to_posture(
    robot: Robot, name: str, held: Shape | None = None, around: Sequence[Shape] = ()
) -> Periods:
    """Move the arm to a named posture of the robot's file, without collisions with the robot and obstacles.

    Args:
        robot: robot whose arm is at its last command.
        name: name of the posture.
        held: held object, posed in the hand frame.
        around: bodies to keep clear of, posed in the base frame.

    Raises:
        Discrepancy: no free path was found.
    """
    yield from move_to_joints(robot, np.array(robot.spec.posture(name)), held, around)


def move_to_pose(
    robot: Robot, base_T_hand: Transform, held: Shape | None = None, around: Sequence[Shape] = ()
) -> Periods:
    """Move the hand to a pose, without collisions with the robot and obstacles.

    The solution of the inverse kinematics nearest to the present posture is tried first. If it is in
    collision, or no free path leads to it, other solutions are tried, free and near ones first.

    Args:
        robot: robot whose arm is at its last command.
        base_T_hand: (4, 4) final pose of the hand.
        held: held object, posed in the hand frame.
        around: bodies to keep clear of, posed in the base frame.

    Raises:
        Discrepancy: the pose is out of reach, or no free path was found.
    """
    here = robot.arm.command()
    joints = robot.arm_model.inverse(base_T_hand, near=here)
    if joints is None:
        x, y, z = base_T_hand[:3, 3]
        raise Discrepancy(f"the arm doesn't reach ({x:.2f}, {y:.2f}, {z:.2f}) m", cause=causes.OUT_OF_REACH)
    if np.allclose(here, joints, atol=GOAL_TOLERANCE_RAD):
        return
    collision = collision_model(robot, held, around)
    path = yield from robot.compute(plan_motion, collision.arm, collision, here, joints)
    if path is None:
        seed = round(robot.time / robot.period)
        path = yield from robot.compute(_plan_another_way, collision, here, base_T_hand, seed)
    if path is None:
        raise _no_way(robot, collision, here, joints)
    yield from follow(robot, path)


def move_to_joints(
    robot: Robot,
    joints: FloatArray,
    held: Shape | None = None,
    around: Sequence[Shape] = (),
    eased: bool = False,
) -> Periods:
    """Move the arm to joint positions, without collisions with the robot and obstacles.

    Continuous joints turn in the shorter direction.

    Args:
        robot: robot whose arm is at its last command.
        joints: (n,) goal, in [rad] or [m].
        held: held object, posed in the hand frame.
        around: bodies to keep clear of, posed in the base frame.
        eased: True if bodies that the arm is closer to than the margin may stay as close, but not come
            closer; False if there is no path then.

    Raises:
        Discrepancy: no free path was found.
    """
    here = robot.arm.command()
    joints = robot.arm_model.nearest(joints, here)
    if np.allclose(here, joints, atol=GOAL_TOLERANCE_RAD):
        return
    collision = collision_model(robot, held, around)
    if eased:
        collision = collision.eased_at(here)
    path = yield from robot.compute(plan_motion, collision.arm, collision, here, joints)
    if path is None:
        raise _no_way(robot, collision, here, joints)
    yield from follow(robot, path)


def move_straight(
    robot: Robot,
    base_T_hand: Transform,
    held: Shape | None = None,
    around: Sequence[Shape] = (),
    eased: bool = False,
) -> Periods:
    """Move the hand to a pose in a straight line.

    Args:
        robot: robot whose arm is at its last command.
        base_T_hand: (4, 4) final pose of the hand.
        held: held object, posed in the hand frame.
        around: bodies to keep clear of, posed in the base frame.
        eased: as for `move_to_joints`.

    Raises:
        Discrepancy: the arm cannot move the hand along the line, or an obstacle is on it.
    """
    collision = collision_model(robot, held, around)
    here = robot.arm.command()
    if eased:
        collision = collision.eased_at(here)
    path = yield from robot.compute(plan_straight, collision.arm, here, base_T_hand, 0.005, collision)
    if path is None:
        x, y, z = base_T_hand[:3, 3]
        raise Discrepancy(
            f"the hand can't go straight to ({x:.2f}, {y:.2f}, {z:.2f}) m", cause=causes.NO_ARM_PATH
        )
    yield from follow(robot, path)


def follow(robot: Robot, path: FloatArray) -> Periods:
    """Move the arm along a path, which is straight in joint space between its points.

    Args:
        robot: robot whose arm is at the first point.
        path: (m, n) joint positions, in [rad] or [m].

    Raises:
        Discrepancy: a joint lags more than `MAX_JOINT_LAG_RAD` behind its command, or more than
            `MAX_SLIDE_LAG_M` if it slides.
    """
    slides = robot.arm_model.slides
    most = np.where(slides, MAX_SLIDE_LAG_M, MAX_JOINT_LAG_RAD)
    for joints in time_path(path, robot.joint_speeds, robot.spec.joint_accelerations(), robot.period)[1:]:
        robot.arm.move(joints)
        yield
        behind = np.abs(robot.arm.joints() - joints)
        worst = int((behind / most).argmax())
        if behind[worst] > most[worst]:
            scale, unit = (1e3, "mm") if slides[worst] else (1.0, "rad")
            off, limit = float(scale * behind[worst]), float(scale * most[worst])
            lag = Measured("Arm", "a joint behind its command", off, limit, unit)
            raise Discrepancy("something stops the arm", measured=lag, cause=causes.ARM_BLOCKED)


def collision_model(robot: Robot, held: Shape | None, around: Sequence[Shape] = ()) -> CollisionModel:
    """Return a model for collision checks of arm, fingers at their present opening, and held object, among
    bodies.

    Args:
        robot: robot with an arm.
        held: held object, posed in the hand frame.
        around: bodies to keep clear of, posed in the base frame.
    """
    gripper, arm = robot.backend.get(Gripper), robot.arm_model  # type: ignore[type-abstract]
    if gripper is not None:
        width = FINGER_RESOLUTION_M * round(max(0.0, gripper.width() / 2.0) / FINGER_RESOLUTION_M)
        arm = arm.with_others({"left_finger": width, "right_finger": width})
    return CollisionModel(arm, around, held, margin=ARM_MARGIN_M, allowed=ALLOWED_CONTACTS)


def _plan_another_way(
    collision: CollisionModel, here: FloatArray, base_T_hand: Transform, seed: int
) -> FloatArray | None:
    """Plan a path (m, n) to one of several postures with the hand at base_T_hand (4, 4); None if none is
    reached.
    """
    found = collision.arm.solutions(base_T_hand, here, restarts=MORE_STARTS, seed=seed)
    free = [joints for joints in found if not collision.in_collision(joints)]
    free.sort(key=lambda joints: float(np.abs(joints - here).max()))
    ways = (plan_motion(collision.arm, collision, here, joints, seed) for joints in free[:MORE_GOALS])
    return next((way for way in ways if way is not None), None)


def _no_way(robot: Robot, collision: CollisionModel, here: FloatArray, joints: FloatArray) -> Discrepancy:
    hits = collision.contacts(joints) or collision.contacts(here)
    beyond = _beyond(robot, here, "is at") or _beyond(robot, joints, "would go to")
    return Discrepancy(beyond or f"the arm finds no free way{_between(hits)}", cause=causes.NO_ARM_PATH)


def _beyond(robot: Robot, angles: FloatArray, verb: str) -> str:
    """Return in words the joints that are beyond their limits by angles (n,) in [rad] or [m]; empty if none
    is.
    """
    arm, units = robot.arm_model, robot.spec.joint_units
    limits = enumerate(zip(angles, arm.lower, arm.upper, arm.endless, strict=True))
    return "; ".join(
        f"{units.names[number]} {verb} {units.words(number, at)}; allowed: {units.words(number, lower)}"
        f" to {units.words(number, upper)}"
        for number, (at, lower, upper, endless) in limits
        if not endless and not lower - LIMIT_ROUNDING <= at <= upper + LIMIT_ROUNDING
    )


def _between(hits: Sequence[tuple[str, str]]) -> str:
    return f": {hits[0][0]} would touch {hits[0][1]}" if hits else ""
