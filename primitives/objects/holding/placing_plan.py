"""Choice of the arm's posture that puts a held object down, by clearance."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import islice
from typing import NamedTuple

import numpy as np

from handcart.backends.description.things.printed_tag import FACE_TURNS, PrintedTag
from handcart.backends.robot.robot import Robot
from handcart.primitives.objects.files.object_kind import ObjectKind
from handcart.primitives.objects.files.surface import ObjectSurface
from handcart.primitives.objects.site.object_site import held_box
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import Transform, inverse, raised, transform
from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.kinematics.shapes import Solid
from handcart.robotics.manipulation.motions.collision_model import ARM_MARGIN_M, CollisionModel
from handcart.robotics.manipulation.motions.motion_planner import plan_straight
from handcart.robotics.numerics.arrays import FloatArray

ABOVE_GOAL_M = 0.07  # where an object waits before it is lowered
FREE_ABOVE_M = 0.008  # over the goal, down to which the object must be clear of everything
FOOT_MARGIN_M = 0.02  # between an object's foot and the edge of the surface, or other objects
WITHDRAWAL_M = 0.07  # of the hand, the way it came from
SPOT_STEP_M = 0.06  # between free spots that are tried
ANY_TURNS_RAD = tuple(math.radians(index) for index in range(0, 360, 45))
MIN_FACING_COSINE = math.cos(math.radians(60.0))  # between a tag's normal and the direction to the robot
IK_RESTARTS = 8
SOLUTIONS_PER_GOAL = 4
GOOD_CLEARANCE_M = 0.02
HAND_MARGIN_M = ARM_MARGIN_M / 2  # of the hand at the goal, beside what a grasp was clear of by the whole
RELEASE_CLEARANCE_M = 0.016  # by which the fingers open to let an object go
STRAIGHT_STEP_M = 0.01
LIMIT_MARGIN = 0.01  # in [rad] or [m], of a joint from its limit


class PlannedPlacing(NamedTuple):
    """Planned placing of an object, by a straight free line down to its goal from a posture above it."""

    base_T_object: Transform
    """Pose (4, 4) of the object at the goal."""
    above: FloatArray
    """Joints (n,), in [rad] or [m], with the object right above the goal."""
    base_T_hand: Transform
    """Pose (4, 4) of the hand at the goal."""


class _PlacingModels(NamedTuple):
    """Collision models of the arm while it puts an object down."""

    loaded: CollisionModel
    """Model with the held object, among all bodies."""
    own: CollisionModel
    """Model of arm and robot alone."""
    opened: CollisionModel
    """Model with opened fingers, among all bodies except the object."""


def goals_on(surface: ObjectSurface, spot: str | None) -> list[Transform]:
    """Return the goal poses map_T_object (4, 4) at a spot of a surface, or in the surface's middle.

    If the heading is free, there are several poses with different headings.
    """
    if spot is None or spot not in surface.spots:
        return turned(surface.floor, surface.height_m, True)
    named = surface.spots[spot]
    return turned(named.pose, surface.height_m, named.heading_deg is None)


def turned(place: Pose2, height: float, any_heading: bool) -> list[Transform]:
    """Return poses (4, 4) of an object's foot at a place, with the place's heading or several headings.

    Args:
        place: position and heading, in any frame.
        height: height of the foot in this frame, in [m].
        any_heading: True for headings all around, False for only that of the place.
    """
    turns = ANY_TURNS_RAD if any_heading else (0.0,)
    return [Pose2(place.x, place.y, place.theta + turn).lift(height) for turn in turns]


def showing_tags(goals: Sequence[Transform], tags: Sequence[PrintedTag]) -> list[Transform]:
    """Return those of the goals at which one of the object's tags faces upwards or the robot.

    At other goals the camera could not verify the object's pose. If no tag faces upwards or the robot at any
    goal, all goals are returned.

    Args:
        goals: base_T_object (4, 4) of the goals.
        tags: tags on the object.
    """
    normals = [transform(rpy=FACE_TURNS[tag.face])[:3, 2] for tag in tags]
    shown = [
        goal
        for goal in goals
        if any(normal[2] > 0.5 or -(goal[:3, :3] @ normal)[0] > MIN_FACING_COSINE for normal in normals)
    ]
    return shown or list(goals)


def plan_placing(
    robot: Robot,
    kind: ObjectKind,
    hand_T_object: Transform,
    goals: Sequence[Transform],
    around: Sequence[Solid],
    width: float | None = None,
) -> PlannedPlacing | None:
    """Return the plan to place an object at the goal with the largest clearance; None if no goal is free. The
    search ends at the first goal with a clearance of at least `GOOD_CLEARANCE_M`.

    Args:
        robot: robot that holds the object, or will hold it.
        kind: kind of the object.
        hand_T_object: (4, 4) pose of the held object.
        goals: base_T_object (4, 4) of allowed poses at the goal.
        around: obstacles for arm and object, in the base frame.
        width: opening of the fingers that hold the object, in [m]; None: the present one.
    """
    arm = _with_hand(robot, robot.gripper.width() if width is None else width)
    collision = CollisionModel(arm, around, held_box(kind, hand_T_object), margin=ARM_MARGIN_M)
    opened = _with_hand(robot, (robot.gripper.width() if width is None else width) + RELEASE_CLEARANCE_M)
    models = _PlacingModels(
        collision,
        CollisionModel(arm, margin=ARM_MARGIN_M),
        CollisionModel(opened, around, margin=HAND_MARGIN_M),
    )
    best, most, here = None, 0.0, robot.arm.command()
    for goal in goals:
        base_T_hand = goal @ inverse(hand_T_object)
        joints = _first_free(models, base_T_hand, here)
        if joints is None:
            continue
        clearance = collision.distance(joints)
        if clearance > most:
            best, most = PlannedPlacing(goal, joints, np.asarray(base_T_hand)), clearance
        if most >= GOOD_CLEARANCE_M:
            break
    return best


def _first_free(models: _PlacingModels, base_T_hand: Transform, here: FloatArray) -> FloatArray | None:
    """Return joints (n,), in [rad] or [m], above a goal with a straight free line down and one back; None if
    none.

    Those whose line ends away from the joints' limits come first: at a limit the hand may be stuck.
    """
    collision, arm = models.loaded, models.loaded.arm
    above, at_limit = raised(base_T_hand, ABOVE_GOAL_M), None
    for joints in islice(arm.solutions(above, here, restarts=IK_RESTARTS), SOLUTIONS_PER_GOAL):
        if collision.in_collision(joints):
            continue
        line = plan_straight(arm, joints, raised(base_T_hand, FREE_ABOVE_M), STRAIGHT_STEP_M, collision)
        down = None if line is None else plan_straight(arm, line[-1], raised(base_T_hand, -FREE_ABOVE_M))
        if line is None or down is None or not _can_withdraw(models, line[-1], down[-1], base_T_hand):
            continue
        if arm.within(down[-1], -LIMIT_MARGIN):
            return joints
        at_limit = joints if at_limit is None else at_limit
    return at_limit


def _can_withdraw(
    models: _PlacingModels, above: FloatArray, below: FloatArray, base_T_hand: Transform
) -> bool:
    """Return whether the opened hand gets back from a goal (4, 4), clear of everything but the object.

    On the last millimetres down the object nears its surface, so only here the hand is checked: it may be
    over the rim of a box.

    Args:
        models: collision models.
        above: (n,) joints right above the goal, in [rad] or [m].
        below: (n,) joints right below it, where an object touches down at the latest.
        base_T_hand: (4, 4) of the hand at the goal.
    """
    arm, back = models.own.arm, withdrawn(base_T_hand)
    if plan_straight(arm, below, back, STRAIGHT_STEP_M, models.own) is None:
        return False
    at_goal = plan_straight(arm, above, base_T_hand)
    if at_goal is None:
        return False
    return plan_straight(arm, at_goal[-1], back, STRAIGHT_STEP_M, models.opened) is not None


def withdrawn(base_T_hand: Transform) -> Transform:
    """Return the pose base_T_hand (4, 4) of a hand after its withdrawal from an object.

    Args:
        base_T_hand: (4, 4) pose of the hand when it released the object.
    """
    return np.asarray(base_T_hand @ transform((-WITHDRAWAL_M, 0.0, 0.0)))


def free_spots(surface: ObjectSurface, radius: float, near: tuple[float, float]) -> list[tuple[float, float]]:
    """Return spots (x, y), in [m] on the map, at which an object's foot is completely on a surface, those
    nearest to a point first. Empty if the surface is too small.

    Args:
        surface: the surface.
        radius: radius of the circle around the foot, in [m].
        near: x and y on the map, in [m].
    """
    length, width = surface.size_m
    inset = radius + FOOT_MARGIN_M
    if min(length, width) < 2.0 * inset:
        return []
    grid = [
        (x, y)
        for x in np.arange(-length / 2 + inset, length / 2 - inset + 1e-9, SPOT_STEP_M).tolist()
        for y in np.arange(-width / 2 + inset, width / 2 - inset + 1e-9, SPOT_STEP_M).tolist()
    ]
    spots = [tuple(item) for item in surface.floor.apply(np.array(grid)).tolist()]
    return sorted(spots, key=lambda spot: math.hypot(spot[0] - near[0], spot[1] - near[1]))


def _with_hand(robot: Robot, width: float) -> ArmModel:
    half = math.ceil(width / 2 * 1e3) / 1e3
    return robot.arm_model.with_others({"left_finger": half, "right_finger": half})
