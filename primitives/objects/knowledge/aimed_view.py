"""Views of a camera that is not on the hand: its head turns it, and the arm stays out of its sight."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import chain

import numpy as np

from handcart.backends.robot.robot import Robot
from handcart.robotics.geometry.transform import Transform
from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.kinematics.shapes import Box
from handcart.robotics.manipulation.grasping.aiming import aim
from handcart.robotics.manipulation.motions.collision_model import CollisionModel
from handcart.robotics.numerics.arrays import FloatArray

MAX_AIM_ERROR_RAD = 0.15  # between the optical axis and the point
LIFT_SHARES = (0.9, 0.6, 0.3, 0.05)  # of the range of a joint that slides and moves arm and camera
ASIDE_TURNS_RAD = (0.4, -0.4, 0.8, -0.8, 1.2, -1.2)
SHIFTS_M = (
    *((0.0, 0.0, -0.12), (0.0, 0.2, 0.0), (0.0, -0.2, 0.0), (0.0, 0.2, -0.12), (0.0, -0.2, -0.12)),
    *((-0.2, side, up) for up in (0.15, 0.3) for side in (0.4, -0.4)),
)
"""Moves of the hand in the base frame, after which a held object may hide less: the far ones bring a bulky
object beside the robot, so that the camera sees the floor before it.
"""
IK_RESTARTS = 2
VERTICAL_COSINE = 0.99  # of the angle between a joint's axis and the vertical
SIGHT_WIDTH_M = 0.10  # around the line from the camera to the point
CORNER_SIGHT_WIDTH_M = 0.01  # likewise to one of several points that a camera on the hand has to show
NEAR_CAMERA_M = 0.15  # that may be the head's own bodies
NEAR_HAND_CAMERA_M = 0.06  # that may be the camera's own body
NEAR_POINT_M = 0.02  # over the point, where sight may touch what is looked at
SIGHT_LINK = "sight"


def aimed_joints(
    robot: Robot, collision: CollisionModel, point: FloatArray, towards: Sequence[FloatArray]
) -> tuple[FloatArray, Transform] | None:
    """Return joints (n,), in [rad] or [m], that turn a camera to a point, and the pose base_T_camera (4, 4).

    The camera is on a head or mast, not on the hand. The arm keeps its posture if it does not hide the point.
    Otherwise the arm takes the first of these postures that neither collides nor hides the point: `home`
    (only with an empty hand), the arm swung aside about a vertical joint, the hand moved down, aside or back.
    All but `home` keep a held object upright. If a lift carries the camera, the free height whose view is
    nearest to the first wanted direction is taken. The result is None if all postures collide or hide the
    point.

    Args:
        robot: robot with a camera behind joints of the section `arm`.
        collision: the arm among its surroundings.
        point: (3,) in the base frame, in [m].
        towards: unit vectors (3,) in the base frame from the point to the camera, the best ones first.
    """
    camera, here = robot.view_camera, robot.arm.command()
    home = [] if collision.holds else [np.array(robot.spec.posture("home"))]
    arm = robot.arm_model
    for posture in chain((here, *home), _asides(arm, here), _shifted(arm, here)):
        views = list(aimed_views(arm, camera.carrier, camera.carrier_T_camera, point, posture))
        views.sort(key=lambda view: -_along(view[1], point, towards))
        for joints, base_T_camera in views:
            if not collision.in_collision(joints) and not collision.touches(
                joints, sight_line(base_T_camera, point)
            ):
                return joints, base_T_camera
    return None


def aimed_views(
    arm: ArmModel, carrier: str, carrier_T_camera: Transform, point: FloatArray, posture: FloatArray
) -> Iterator[tuple[FloatArray, Transform]]:
    """Yield pairs: joints (n,), in [rad] or [m], that turn a camera to a point, and base_T_camera (4, 4).

    If the arm has a lift, a pair is yielded for each of some heights of the lift, otherwise a single pair.
    Nothing is yielded for a height at which the camera cannot be turned to the point.

    Args:
        arm: kinematics of arm and head.
        carrier: link that carries the camera.
        carrier_T_camera: (4, 4) of the optical frame.
        point: (3,) in the base frame, in [m].
        posture: (n,) of all joints, in [rad] or [m]; those that move the hand stay there, except lifts.
    """
    above = arm.moving(carrier)
    turning = above & ~arm.moves_tip
    lifts = np.flatnonzero(above & arm.moves_tip & arm.slides)
    for share in LIFT_SHARES if len(lifts) else (0.0,):
        start = np.array(posture, dtype=np.float64)
        start[lifts] = arm.lower[lifts] + share * (arm.upper[lifts] - arm.lower[lifts])
        joints, off = aim(arm, carrier, carrier_T_camera, point, turning, start)
        if off < MAX_AIM_ERROR_RAD:
            yield joints, np.asarray(arm.forward(joints, carrier) @ carrier_T_camera)


def _asides(arm: ArmModel, here: FloatArray) -> Iterator[FloatArray]:
    """Yield postures (n,) like `here`, in [rad] or [m], with the arm turned about a joint whose axis is
    vertical.
    """
    vertical = np.abs(arm.jacobian(here)[5]) > VERTICAL_COSINE
    for number in np.flatnonzero(vertical & arm.moves_tip & ~arm.slides):
        for turn in ASIDE_TURNS_RAD:
            posture = here.copy()
            posture[number] += turn
            if arm.within(posture):
                yield posture


def _shifted(arm: ArmModel, here: FloatArray) -> Iterator[FloatArray]:
    """Yield postures (n,), in [rad] or [m], whose hand is moved from its pose in `here` without a
    turn: down, aside, back.
    """
    base_T_hand = arm.forward(here)
    for shift in SHIFTS_M:
        moved = base_T_hand.copy()
        moved[:3, 3] += shift
        posture = arm.inverse(moved, here, restarts=IK_RESTARTS)
        if posture is not None:
            yield posture


def _along(base_T_camera: Transform, point: FloatArray, towards: Sequence[FloatArray]) -> float:
    """Return the cosine of the angle between a view's direction and the first wanted one; 1 is best, 0 if
    none is wanted.

    Args:
        base_T_camera: (4, 4) of the view.
        point: (3,) point that is looked at, in the base frame in [m].
        towards: wanted unit vectors (3,) from the point to the camera.
    """
    back = base_T_camera[:3, 3] - point
    return float(towards[0] @ back / np.linalg.norm(back)) if towards else 0.0


def hidden_count(
    collision: CollisionModel, joints: FloatArray, base_T_camera: Transform, points: FloatArray
) -> int:
    """Return how many points are hidden from a camera on the hand, by the hand, the object in it, or an
    obstacle.

    Args:
        collision: the arm with the object, among the obstacles.
        joints: (n,) in [rad] or [m].
        base_T_camera: (4, 4) of the camera at these joints.
        points: (m, 3) in the base frame, in [m].
    """
    lines = [sight_line(base_T_camera, point, CORNER_SIGHT_WIDTH_M, NEAR_HAND_CAMERA_M) for point in points]
    return sum(collision.obstacle_touches(line) or collision.touches(joints, line) for line in lines)


def sight_line(
    base_T_camera: Transform, point: FloatArray, width: float = SIGHT_WIDTH_M, nearest: float = NEAR_CAMERA_M
) -> Box:
    """Return the line of sight from a camera to a point as a body in the base frame.

    Args:
        base_T_camera: (4, 4) of the camera.
        point: (3,) in the base frame, in [m].
        width: width of the line of sight, in [m].
        nearest: distance from the camera at which sight begins, in [m].
    """
    line = point - base_T_camera[:3, 3]
    length = float(np.linalg.norm(line))
    near, far = min(nearest, length / 3), NEAR_POINT_M
    pose = np.eye(4)
    pose[:3, :3] = base_T_camera[:3, :3]
    pose[:3, 2] = line / length
    pose[:3, 0] = np.cross(pose[:3, 1], pose[:3, 2])
    pose[:3, 0] /= np.linalg.norm(pose[:3, 0])
    pose[:3, 1] = np.cross(pose[:3, 2], pose[:3, 0])
    pose[:3, 3] = base_T_camera[:3, 3] + line / length * (near + length - far) / 2
    return Box(pose, (width, width, length - near - far), SIGHT_LINK)
