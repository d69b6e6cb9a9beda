"""Postures in which the arm carries an object: upright, within the robot's outline."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from handcart.backends.robot.robot import Robot
from handcart.primitives.contract.action_primitive import Periods
from handcart.primitives.knowledge.world_model import ModelView
from handcart.primitives.motions.arm_motion import collision_model
from handcart.primitives.objects.files.object_kind import ObjectKind
from handcart.primitives.objects.site.object_site import held_box
from handcart.primitives.objects.site.roomy_motion import move_with_room, surroundings_to_try
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy
from handcart.robotics.geometry.transform import Transform, apply, inverse, transform
from handcart.robotics.kinematics.shapes import Solid, corners
from handcart.robotics.numerics.arrays import FloatArray

OUTLINE_MARGIN_M = 0.02  # within the robot's outline
GOOD_CLEARANCE_M = 0.015
MORE_POSTURES = 60  # tried after the first hit, for one with the whole arm within the outline
STEP_M = 0.06  # between tried places of the hand
HEIGHTS_M = (0.06, 0.12, 0.2)  # of the object's foot over the body
TURNS_RAD = tuple(math.radians(index) for index in range(0, 360, 45))
IK_RESTARTS = 2


def stow(
    robot: Robot,
    model: ModelView,
    kind: ObjectKind | None = None,
    hand_T_object: Transform | None = None,
) -> Periods:
    """Bring the hand within the robot's outline, with a held object upright if its kind requires it.

    Args:
        robot: robot with its arm in any posture.
        model: world model with the surfaces and objects that the arm must not touch.
        kind: kind of the held object; None for an empty hand.
        hand_T_object: (4, 4) pose of the held object.

    Raises:
        Discrepancy: no posture within the outline is found, or no free path leads to it.
    """
    if kind is None or hand_T_object is None:
        yield from move_with_room(robot, model, np.array(robot.spec.posture("home")))
        return
    for around in surroundings_to_try(robot, model):
        joints = yield from robot.compute(carrying_joints, robot, kind, hand_T_object, around)
        if joints is not None:
            break
    else:
        raise Discrepancy("the arm finds no posture to carry it in", cause=causes.NO_ARM_PATH)
    yield from move_with_room(robot, model, joints, held_box(kind, hand_T_object))


def carrying_joints(
    robot: Robot, kind: ObjectKind, hand_T_object: Transform, around: Sequence[Solid] = ()
) -> FloatArray | None:
    """Return a posture in which the arm carries an object within the robot's outline; None if none is found.

    A posture with the complete arm within the outline is preferred, because an elbow outside of it may hit
    obstacles that the base drives past. The search ends at the first such posture whose clearance is at least
    `GOOD_CLEARANCE_M`.

    Args:
        robot: robot with the object in its hand.
        kind: kind of the object.
        hand_T_object: (4, 4) pose of the object in the hand frame.
        around: solids that arm and object must not touch, in the base frame.

    Returns:
        Joint positions (n,), in [rad] or [m].
    """
    held = held_box(kind, hand_T_object)
    collision, here = collision_model(robot, held, around), robot.arm.command()
    best, most, left = None, -math.inf, MORE_POSTURES
    home = np.array(robot.spec.posture("home"))
    if not kind.upright and _is_inside(robot, robot.arm_model.forward(home), held):
        best, most = (home, GOOD_CLEARANCE_M) if not collision.in_collision(home) else (None, most)
    for base_T_hand in _hands(robot, hand_T_object):
        if most >= GOOD_CLEARANCE_M or left <= 0:
            break
        if not _is_inside(robot, base_T_hand, held):
            continue
        joints = robot.arm_model.inverse(base_T_hand, here, restarts=IK_RESTARTS)
        if joints is not None and not collision.in_collision(joints):
            score = min(GOOD_CLEARANCE_M, collision.distance(joints)) - _reach_out(robot, joints)
            left -= best is not None
            if score > most:
                best, most = joints, score
    return best


def _reach_out(robot: Robot, joints: FloatArray) -> float:
    """Return how far the arm at joints (n,), in [rad] or [m], reaches out of the robot's outline, in [m]; 0
    inside.
    """
    bodies = np.vstack([corners(shape) for shape in robot.arm_model.moved_shapes(joints)])
    return max(0.0, float(robot.spec.footprint_shape.distances(bodies[:, :2]).max()))


def _hands(robot: Robot, hand_T_object: Transform) -> Iterator[Transform]:
    """Yield base_T_hand (4, 4) with the object upright over the robot, those ahead in the middle first."""
    object_T_hand = inverse(hand_T_object)
    reach = robot.spec.footprint_shape.inscribed
    steps = np.arange(-reach, reach + 1e-9, STEP_M)
    spots = sorted(
        ((float(x), float(y)) for x in steps for y in steps if math.hypot(x, y) < reach),
        key=lambda item: math.hypot(item[0] - reach / 3, item[1]),
    )
    for height in HEIGHTS_M:
        for x, y in spots:
            for turn in TURNS_RAD:
                pose = transform((x, y, robot.spec.body_height + height), (0.0, 0.0, turn))
                yield np.asarray(pose @ object_T_hand)


def _is_inside(robot: Robot, base_T_hand: Transform, held: Solid) -> bool:
    """Return whether the hand, its finger tips and the object are within the robot's outline."""
    tips = apply(base_T_hand, np.array([[0.0, 0.0, 0.0], [robot.spec.finger_shape.tip, 0.0, 0.0]]))
    body = corners(held.seen_from(base_T_hand))
    away = robot.spec.footprint_shape.distances(np.vstack([tips, body])[:, :2])
    return bool(away.max() <= -OUTLINE_MARGIN_M)
