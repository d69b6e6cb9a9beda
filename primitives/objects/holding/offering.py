"""Postures in which the arm offers an object to a person."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from handcart.backends.robot.robot import Robot
from handcart.primitives.motions.arm_motion import collision_model
from handcart.primitives.objects.files.object_kind import ObjectKind
from handcart.primitives.objects.site.object_site import held_box
from handcart.robotics.geometry.transform import Transform, apply, inverse, transform
from handcart.robotics.kinematics.shapes import Solid
from handcart.robotics.numerics.arrays import FloatArray

AHEAD_M = (0.20, 0.30, 0.12, 0.40)  # of the object beyond the robot's outline
BEARINGS_RAD = tuple(math.radians(value) for value in (0, 25, -25, 50, -50, 90, -90))
METRES_PER_RADIAN = 0.3  # of height, that a bearing beside the way ahead costs
HEIGHT_STEP_M = 0.08
MAX_LOWER_M, MAX_HIGHER_M = 0.56, 0.16  # that the object may be off the wanted height
TURNS_RAD = tuple(math.radians(index) for index in range(0, 360, 45))
IK_RESTARTS = 1
MAX_TRIES = 400  # of the inverse kinematics
MORE_POSTURES = 12  # that are looked at once one is free
METRES_PER_HALF_TURN = 0.2  # of height, that a hand which points away from the person costs


def offering_joints(
    robot: Robot,
    kind: ObjectKind,
    hand_T_object: Transform,
    height_m: float,
    around: Sequence[Solid] = (),
) -> FloatArray | None:
    """Return joints (n,), in [rad] or [m], that hold an object out ahead of the robot without a collision.

    The object is upright, beyond the robot's outline, as near to the wanted height as the arm reaches. The
    hand is preferred behind or above the object, so that a person can take hold of it. The result is None if
    no such posture is found.

    Args:
        robot: robot with its arm in any posture.
        kind: kind of the held object.
        hand_T_object: (4, 4) pose of the held object.
        height_m: wanted height of the middle of the object over the floor, in [m].
        around: obstacles for the arm, in the base frame.
    """
    held = held_box(kind, hand_T_object)
    collision, here = collision_model(robot, held, around), robot.arm.command()
    best, least, left = None, math.inf, MORE_POSTURES
    for tries, (cost, base_T_hand) in enumerate(_candidates(robot, kind, hand_T_object, height_m)):
        if tries >= MAX_TRIES or left <= 0:
            break
        joints = robot.arm_model.inverse(base_T_hand, here, restarts=IK_RESTARTS)
        if joints is None or collision.in_collision(joints):
            continue
        left -= 1
        turned = float(np.abs(joints - here).max()) / math.pi
        if cost + METRES_PER_HALF_TURN * turned < least:
            best, least = joints, cost + METRES_PER_HALF_TURN * turned
    return best


def is_outside(robot: Robot, base_T_hand: Transform) -> bool:
    """Return whether the finger tips of a hand at base_T_hand (4, 4) are beyond the robot's outline."""
    tips = apply(base_T_hand, np.array([[robot.spec.finger_shape.tip, 0.0, 0.0]]))
    return bool(robot.spec.footprint_shape.distances(tips[:, :2])[0] > 0.0)


def _candidates(
    robot: Robot, kind: ObjectKind, hand_T_object: Transform, height_m: float
) -> Iterator[tuple[float, Transform]]:
    """Yield costs in [m], and base_T_hand (4, 4), the cheapest first."""
    object_T_hand, half = inverse(hand_T_object), kind.size[2] / 2
    outline = robot.spec.footprint_shape.outline(0.0, 0.0, 0.0)
    found: list[tuple[float, Transform]] = []
    for bearing, ahead in ((b, a) for b in BEARINGS_RAD for a in AHEAD_M):
        out = np.array([math.cos(bearing), math.sin(bearing)])
        x, y = ((outline @ out).max() + ahead + kind.foot_radius) * out
        for off, turn in ((o, t) for o in _height_offsets() for t in TURNS_RAD):
            pose = transform((float(x), float(y), height_m + off - half), (0.0, 0.0, turn))
            base_T_hand = np.asarray(pose @ object_T_hand)
            facing = METRES_PER_HALF_TURN * (1.0 - float(base_T_hand[:2, 0] @ out)) / 2.0
            beside = 0.5 * abs(ahead - AHEAD_M[0]) + METRES_PER_RADIAN * abs(bearing)
            found.append((abs(off) + beside + facing, base_T_hand))
    yield from sorted(found, key=lambda pair: pair[0])


def _height_offsets() -> list[float]:
    lower, higher = round(MAX_LOWER_M / HEIGHT_STEP_M), round(MAX_HIGHER_M / HEIGHT_STEP_M)
    return [step * HEIGHT_STEP_M for step in range(-lower, higher + 1)]
