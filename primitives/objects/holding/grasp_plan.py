"""Choice of a grasp and of the arm's posture for it, by clearance."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from handcart.backends.robot.robot import Robot
from handcart.primitives.objects.files.object_kind import ObjectKind
from handcart.robotics.geometry.transform import Transform, inverse, transform
from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.kinematics.shapes import Solid
from handcart.robotics.manipulation.grasping.box_grasps import Grasp
from handcart.robotics.manipulation.motions.collision_model import ARM_MARGIN_M, CollisionModel
from handcart.robotics.manipulation.motions.motion_planner import plan_straight
from handcart.robotics.numerics.arrays import FloatArray

GRASP_APPROACH_M = 0.07  # before a grasp, where the hand lines up
OPENING_CLEARANCE_M = 0.016  # wider than the object
GOOD_CLEARANCE_M = 0.03  # more adds nothing
LIFT_M = 0.08
TILT_PRICE_M = 0.01  # of clearance, for a turn of a radian from straight
SIDE_PRICE_M = 0.004  # of clearance, for a hand that does not come from above
IK_RESTARTS = 3
SOLUTIONS_PER_GRASP = 2
STRAIGHT_STEP_M = 0.01
MAX_ROUND_COSINE = 0.7  # between the axis of a cylinder and the closing direction, for pads on its side
GRASPS_TRIED = 12  # whose straight lines are looked at


class PlannedGrasp(NamedTuple):
    """Planned grasp of an object, with a straight path of the hand to the object and then up with it, on
    which nothing is touched.
    """

    grasp: Grasp
    before: FloatArray
    """(n,) joints where the hand lines up, in [rad] or [m]."""
    base_T_grip: Transform
    """Pose (4, 4) of the hand around the object."""
    clearance: float
    """Least distance to anything but the object, in [m]."""


class GraspChoice(NamedTuple):
    """Collision-free grasps found for an object, the best one first; also the number of grasps that were
    tried, and the number of those that the arm can reach.
    """

    planned: tuple[PlannedGrasp, ...]
    """Free grasps, the best one first."""
    reached: int
    """Number of grasps that the arm reaches, free or not."""
    tried: int


class _ModelsAmong:
    """Collision models of arms among the same bodies; each is made once, as many grasps open a hand alike."""

    def __init__(self, around: Sequence[Solid]) -> None:
        self._around, self._made = tuple(around), dict[ArmModel, CollisionModel]()

    def of(self, arm: ArmModel) -> CollisionModel:
        """Return the model of an arm."""
        if arm not in self._made:
            self._made[arm] = CollisionModel(arm, self._around, margin=ARM_MARGIN_M)
        return self._made[arm]


def plan_grasps(
    robot: Robot, kind: ObjectKind, base_T_object: Transform, around: Sequence[Solid], target: Solid
) -> GraspChoice:
    """Return the grasps of an object that touch nothing else, ranked by clearance.

    Grasps straight from above are preferred.

    Args:
        robot: robot with an arm and a gripper.
        kind: kind of the object.
        base_T_object: (4, 4) pose of the object.
        around: obstacles for the arm, in the base frame, without the object.
        target: shape of the object, in the base frame.
    """
    spec = robot.spec.gripper
    opening = spec.opening_mm / 1e3 if spec is not None else 0.0
    here, with_target, without = robot.arm.command(), _ModelsAmong((*around, target)), _ModelsAmong(around)
    found: list[tuple[float, FloatArray, Grasp]] = []
    tried = reached = 0
    for grasp in kind.grasps_within(opening, robot.spec.finger_shape.tip, base_T_object):
        tried += 1
        arm = _with_opening(robot, min(opening, grasp.width + OPENING_CLEARANCE_M))
        grip = base_T_object @ grasp.box_T_hand
        ahead = grip @ transform((-GRASP_APPROACH_M, 0.0, 0.0))
        postures = _some(arm, ahead, here)
        reached += bool(postures)
        for before in postures:
            lined_up = with_target.of(arm)
            if not lined_up.in_collision(before):
                price = TILT_PRICE_M * abs(grasp.tilt) + SIDE_PRICE_M * (grasp.face != "+z")
                score = min(GOOD_CLEARANCE_M, lined_up.distance(before)) - price
                found.append((score, before, grasp))
    found.sort(key=lambda entry: -entry[0])
    planned = []
    for _, before, grasp in found[:GRASPS_TRIED]:
        one = _free_way(robot, grasp, before, base_T_object, without, opening)
        if one is not None:
            planned.append(one)
    planned.sort(key=lambda item: -_rank(item))
    return GraspChoice(tuple(planned), reached, tried)


def _rank(planned: PlannedGrasp) -> float:
    price = TILT_PRICE_M * abs(planned.grasp.tilt) + SIDE_PRICE_M * (planned.grasp.face != "+z")
    return min(GOOD_CLEARANCE_M, planned.clearance) - price


def _free_way(
    robot: Robot,
    grasp: Grasp,
    before: FloatArray,
    base_T_object: Transform,
    around: _ModelsAmong,
    opening: float,
) -> PlannedGrasp | None:
    """Return the grasp if a straight free line leads to it, and one up again; None otherwise.

    Args:
        robot: robot with an arm and a gripper.
        grasp: the grasp, relative to the object.
        before: (n,) joints where the hand lines up, in [rad] or [m].
        base_T_object: (4, 4) pose of the object.
        around: models of arms among the bodies that must not be touched.
        opening: largest opening of the fingers, in [m].
    """
    arm = _with_opening(robot, min(opening, grasp.width + OPENING_CLEARANCE_M))
    collision = around.of(arm)
    grip = base_T_object @ grasp.box_T_hand
    line = plan_straight(arm, before, grip, STRAIGHT_STEP_M, collision)
    if line is None:
        return None
    lifted = grip.copy()
    lifted[2, 3] += LIFT_M
    if plan_straight(arm, line[-1], lifted, STRAIGHT_STEP_M, collision) is None:
        return None
    clearance = min(collision.distance(line[-1]), collision.distance(before))
    return PlannedGrasp(grasp, before, np.asarray(grip), clearance)


def _some(arm: ArmModel, base_T_hand: Transform, here: FloatArray) -> list[FloatArray]:
    """Return a few postures (n,), in [rad] or [m], with the hand at a pose (4, 4); the search starts at
    `here`.
    """
    found = []
    for joints in arm.solutions(base_T_hand, here, restarts=IK_RESTARTS):
        found.append(joints)
        if len(found) == SOLUTIONS_PER_GRASP:
            break
    return found


def _with_opening(robot: Robot, width: float) -> ArmModel:
    half = math.ceil(width / 2 * 1e3) / 1e3
    return robot.arm_model.with_others({"left_finger": half, "right_finger": half})


def gripped(base_T_hand: Transform, base_T_object: Transform, is_round: bool = False) -> Transform:
    """Return the pose hand_T_object (4, 4) of an object after the finger pads have closed on it.

    The pads centre the object between them, and turn its sides parallel to them.

    Args:
        base_T_hand: (4, 4) pose of the hand around the object.
        base_T_object: (4, 4) pose of the object, as measured before.
        is_round: True for a cylinder, which the pads do not turn about its axis.
    """
    hand_T_object = inverse(base_T_hand) @ base_T_object
    axis = hand_T_object[:3, 2]
    closing = int(np.argmax(np.abs(hand_T_object[1, :3])))
    normal = hand_T_object[:3, closing]
    if is_round and abs(axis[1]) < MAX_ROUND_COSINE:
        normal = np.array([0.0, 1.0, 0.0]) - axis[1] * axis
        normal /= np.linalg.norm(normal)
    goal = np.array([0.0, math.copysign(1.0, normal[1]), 0.0])
    axis = np.cross(normal, goal)
    sine, cosine = float(np.linalg.norm(axis)), float(normal @ goal)
    turn = np.eye(3)
    if sine > 1e-9:
        x, y, z = axis / sine
        skew = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        turn = np.eye(3) + sine * skew + (1.0 - cosine) * skew @ skew  # Rodrigues' formula
    result = np.eye(4)
    result[:3, :3] = turn @ hand_T_object[:3, :3]
    result[:3, 3] = hand_T_object[:3, 3]
    result[1, 3] = 0.0
    return result
