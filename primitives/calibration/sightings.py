"""Looking at known landmarks from straight above, without swinging the arm."""

from __future__ import annotations

import math
from collections.abc import Generator, Sequence
from typing import NamedTuple

import numpy as np

from handcart.backends.robot.robot import Robot
from handcart.primitives.blocks.building import LandmarkPlan
from handcart.primitives.motions.arm_motion import move_straight
from handcart.primitives.motions.from_above import on_level, pointing_down
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy, Measured
from handcart.primitives.outcomes.evidence import Evidence
from handcart.primitives.restoring.snapshot import settle
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import Transform, inverse
from handcart.robotics.kinematics.shapes import Box
from handcart.robotics.perception.drawing.overlay import draw_overlay
from handcart.robotics.perception.landmarks.landmark import Landmark
from handcart.robotics.perception.landmarks.landmark_finder import find_landmarks
from handcart.robotics.perception.landmarks.landmark_pose import planar_pose

CREEP_SWING_SHARE = 0.75  # of what counts as a swing: so far the hand is moved at once
LANDMARK_RADIUS_M = 0.05  # from its place within which a landmark counts
LANDMARK_DEPTH_TOLERANCE_M = 0.06  # by which it may be nearer or farther than planned


class Seen(NamedTuple):
    """One sighting of a landmark by the hand's camera, with the pose of the hand from the measured joints,
    and that of the landmark from the picture.
    """

    landmark: Landmark
    base_T_hand: Transform
    base_T_landmark: Pose2
    """Pose of the landmark in the base frame by the picture, with the base assumed to be level."""


def above(robot: Robot, base_T_mark: Transform, height: float) -> Transform:
    """Return base_T_hand (4, 4), pointing down, with the camera straight above a landmark.

    Args:
        robot: robot whose hand-eye calibration is used.
        base_T_mark: (4, 4) pose of the landmark.
        height: height of the camera above the landmark, in [m].
    """
    hand = pointing_down(Pose2(0.0, 0.0, 0.0), 0.0)
    hand[:3, 3] = base_T_mark[:3, 3] + (0.0, 0.0, height) - (hand @ robot.camera.hand_T_camera)[:3, 3]
    return np.asarray(hand)


def creep(
    robot: Robot, base_T_hand: Transform, held: Box, around: Sequence[Box]
) -> Generator[None, None, int]:
    """Move the hand straight to a pose, in steps so short that the base does not turn.

    A swing is a longer motion of the loaded hand, which turns the base. If the robot's file counts every
    motion as a swing, the hand moves in one step.

    Args:
        robot: robot whose arm is at its last command.
        base_T_hand: (4, 4) final pose of the hand.
        held: held object, posed in the hand frame.
        around: obstacles for the arm, posed in the base frame.

    Returns:
        Number of swings, 0 or 1.
    """
    start = robot.arm_model.forward(robot.arm.command())
    way = base_T_hand[:3, 3] - start[:3, 3]
    step = CREEP_SWING_SHARE * robot.spec.suspension.swing_from_mm / 1e3
    count = max(1, math.ceil(float(np.linalg.norm(way[:2])) / step)) if step > 0.0 else 1
    for n in range(1, count + 1):
        place = base_T_hand.copy()
        place[:3, 3] = start[:3, 3] + way * n / count
        yield from move_straight(robot, place, held, around)
        yield
    return 0 if step > 0.0 else 1


def see(
    robot: Robot, mark: LandmarkPlan, base_T_mark: Transform, evidence: Evidence
) -> Generator[None, None, Seen]:
    """Take one picture of a landmark below the camera.

    Args:
        robot: robot whose hand is above the landmark.
        mark: the landmark of the plan.
        base_T_mark: (4, 4) expected pose of the landmark.
        evidence: evidence of the attempt, to which the picture is added.

    Raises:
        Discrepancy: the picture does not show the landmark.
    """
    yield from settle(robot)
    yield
    photo, base_T_hand = robot.photo(), robot.base_T("hand")
    away = float(photo.base_T_camera[2, 3] - base_T_mark[2, 3])
    span = (away - LANDMARK_DEPTH_TOLERANCE_M, away + LANDMARK_DEPTH_TOLERANCE_M)
    found = find_landmarks(photo.pixels, photo.camera, mark.side_mm / 1e3, span)
    evidence.pictures["landmark"] = draw_overlay(photo.pixels, landmarks=found)
    level = Pose2(0.0, 0.0, 0.0).lift(float(base_T_mark[2, 3]))
    camera_T_level = inverse(photo.base_T_camera) @ level
    expected = on_level(base_T_mark)
    seen = [Seen(landmark, base_T_hand, planar_pose(landmark, camera_T_level)) for landmark in found]
    near = [seen_ for seen_ in seen if seen_.base_T_landmark.distance(expected) < LANDMARK_RADIUS_M]
    if not near:
        nothing = Measured("Camera", "landmarks where one should be", len(near), 1)
        raise Discrepancy("a landmark is not where it should be", measured=nothing, cause=causes.MISPLACED)
    return min(near, key=lambda seen_: seen_.base_T_landmark.distance(expected))
