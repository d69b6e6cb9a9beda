"""Measure the pose of a block with the camera above it."""

from __future__ import annotations

import math
from collections.abc import Generator, Sequence

import numpy as np

from handcart.backends.robot.robot import Robot
from handcart.primitives.motions.arm_motion import move_to_pose
from handcart.primitives.motions.from_above import on_level, pointing_down
from handcart.primitives.outcomes.evidence import Evidence
from handcart.primitives.restoring.snapshot import settle
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import Transform, apply, inverse
from handcart.robotics.kinematics.shapes import Box
from handcart.robotics.numerics.arrays import FloatArray
from handcart.robotics.perception.blocks.block_finder import MAX_TURN_RAD, find_block
from handcart.robotics.perception.blocks.nearest_face import nearest_face
from handcart.robotics.perception.drawing.overlay import draw_overlay

from .building import Building
from .building_site import VIEW_DISTANCE_M

BLOCK_SEARCH_RADIUS_M = 0.015  # around the expected position
BLOCK_MAX_PICTURES = 2  # pictures


def see_block(
    robot: Robot, plan: Building, base_T_block: Transform, evidence: Evidence, around: Sequence[Box] = ()
) -> Generator[None, None, Pose2 | None]:
    """Move the camera over a block and measure its pose in the base frame; None if it is not seen.

    Args:
        robot: robot with an empty hand.
        plan: building plan with the size of the blocks.
        base_T_block: (4, 4), expected pose.
        evidence: evidence of the attempt, to which the picture is added.
        around: obstacles for the arm, in the base frame.
    """
    length, width, height = plan.block
    top = base_T_block.copy()
    top[2, 3] += height
    view = pointing_down(Pose2(0.0, 0.0, on_level(top).theta), 0.0)
    view[:3, 3] = top[:3, 3] + (0.0, 0.0, VIEW_DISTANCE_M) - (view @ robot.camera.hand_T_camera)[:3, 3]
    yield from move_to_pose(robot, view, around=around)
    for _ in range(BLOCK_MAX_PICTURES):
        yield from settle(robot)
        yield
        photo = robot.photo()
        camera_T_top = inverse(photo.base_T_camera) @ _flat(top[2, 3])
        seen = find_block(
            photo.pixels, photo.camera, camera_T_top, (length, width), on_level(top), BLOCK_SEARCH_RADIUS_M
        )
        drawn = [] if seen is None else [_outline(seen, camera_T_top, length, width)]
        outlines = [photo.camera.project(item) for item in drawn]
        evidence.pictures["block"] = draw_overlay(photo.pixels, outlines=outlines)
        if seen is not None:
            return _as_block(seen, on_level(top))
    return None


def why_unseen(robot: Robot, plan: Building, base_T_block: Transform) -> str:
    """Return a message why no block was found at its expected pose, for use after `see_block` has failed.

    A further picture is taken and searched for the bright face nearest to the expected pose.
    """
    length, width, height = plan.block
    photo = robot.photo()
    camera_T_top = inverse(photo.base_T_camera) @ _flat(float(base_T_block[2, 3]) + height)
    face = nearest_face(photo.pixels, photo.camera, camera_T_top, on_level(base_T_block))
    needed = (
        f"needed: {_size(max(length, width), min(length, width))}, brighter than its surroundings, at most "
        f"{1e3 * BLOCK_SEARCH_RADIUS_M:.0f} mm and {math.degrees(MAX_TURN_RAD):.0f} deg off"
    )
    if face is None:
        return f"no face there is brighter than its surroundings; {needed}"
    long_axis = 0.0 if length >= width else math.pi / 2
    turn = abs(math.remainder(face.direction - long_axis, math.pi))
    off = f"{1e3 * face.distance:.0f} mm and {math.degrees(turn):.0f} deg off"
    return f"the nearest bright face is {_size(face.long_side, face.short_side)}, {off}; {needed}"


def _size(long_side: float, short_side: float) -> str:
    return f"{1e3 * long_side:.0f} x {1e3 * short_side:.0f} mm"


def _flat(height: float) -> Transform:
    """Return base_T_plane (4, 4) of a level plane at a height in [m]."""
    return Pose2(0.0, 0.0, 0.0).lift(height)


def _as_block(seen: Pose2, expected: Pose2) -> Pose2:
    """Return a seen pose, turned half around if that heading, which looks the same, is nearer to the expected
    one.
    """
    turned = math.cos(seen.theta - expected.theta) < 0.0
    return seen.compose(Pose2(0.0, 0.0, math.pi)) if turned else seen


def _outline(place: Pose2, camera_T_top: Transform, length: float, width: float) -> FloatArray:
    """Return the corners (4, 3) of a block's top in the camera frame, in [m]."""
    corners = place.apply(np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]]) * (length / 2, width / 2))
    return apply(camera_T_top, np.column_stack([corners, np.zeros(4)]))
