"""Views of a surface that together show where an object may be."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import product
from typing import Literal

import numpy as np

from handcart.backends.description.things.printed_tag import FACE_TURNS, PrintedTag
from handcart.backends.robot.mounted_camera import HAND_LINK
from handcart.backends.robot.robot import Robot
from handcart.primitives.objects.files.surface import ObjectSurface
from handcart.primitives.objects.knowledge.aimed_view import aimed_joints, hidden_count
from handcart.robotics.geometry.transform import Transform, inverse, transform
from handcart.robotics.manipulation.grasping.camera_poses import camera_poses, from_direction
from handcart.robotics.manipulation.motions.collision_model import CollisionModel
from handcart.robotics.numerics.arrays import FloatArray

Direction = Literal["any", "above", "slanted"]
"""Directions from which the camera may look at an object."""
SPACING_M = 0.04  # between places where the object may be
ELSEWHERE_SHARE = 0.05  # of the belief that is spread over the whole surface
IK_RESTARTS = 3
ABOVE_RAD = (0.0, math.radians(15.0))
SLANTED_RAD = (math.radians(35.0), math.radians(50.0))
SIDE_TAG_TILT_RAD = math.radians(55.0)
ROBOT_AZIMUTHS_RAD = tuple(math.radians(value) for value in (180.0, 140.0, -140.0, 90.0, -90.0))
"""Directions from a point ahead of the robot to the camera: back towards it first."""


def places_and_weights(
    surface: ObjectSurface, believed: tuple[float, float] | None, sigma: float
) -> tuple[FloatArray, FloatArray]:
    """Return places (n, 2) on the map, in [m], where a searched object may be, and their probabilities (n,).

    Args:
        surface: surface on which the object is.
        believed: x and y on the map, in [m], at which the object is believed to be; None if it may be
            anywhere on the surface.
        sigma: standard deviation of `believed` along each axis, in [m].
    """
    length, width = surface.size_m
    grid = np.stack(
        np.meshgrid(
            _spread(length),
            _spread(width),
        ),
        axis=-1,
    ).reshape(-1, 2)
    places = surface.floor.apply(grid)
    weights = np.full(len(places), 1.0 / len(places))
    if believed is not None:
        off = np.hypot(*(places - believed).T) / max(sigma, SPACING_M / 2)
        near = np.exp(-0.5 * off**2)
        weights = ELSEWHERE_SHARE * weights + (1.0 - ELSEWHERE_SHARE) * near / max(float(near.sum()), 1e-12)
    return places, weights


def _spread(extent: float) -> FloatArray:
    count = max(1, round(extent / SPACING_M))
    return (np.arange(count) + 0.5) / count * extent - extent / 2


def directions(tags: Sequence[PrintedTag], heading: float | None, wanted: Direction) -> Iterator[FloatArray]:
    """Yield unit vectors (3,) in the base frame from the object to the camera, the best ones first.

    Args:
        tags: tags of the object.
        heading: expected heading of the object in the base frame, in [rad]; None if unknown.
        wanted: directions to which the views are restricted.
    """
    on_top = any(printed_tag.face == "+z" for printed_tag in tags) or not tags
    if on_top and wanted != "slanted":
        yield from (from_direction(tilt, math.pi) for tilt in ABOVE_RAD)
    if heading is not None and wanted != "above":
        for tag in tags:
            if tag.face[1] != "z":
                normal = transform(rpy=FACE_TURNS[tag.face])[:3, 2]
                azimuth = math.atan2(normal[1], normal[0]) + heading
                yield from (from_direction(SIDE_TAG_TILT_RAD, azimuth + turn) for turn in (0.0, 0.5, -0.5))
    if wanted != "above":
        yield from (from_direction(tilt, azimuth) for tilt in SLANTED_RAD for azimuth in ROBOT_AZIMUTHS_RAD)


def view_joints(
    robot: Robot,
    collision: CollisionModel,
    point: FloatArray,
    towards: Sequence[FloatArray],
    distances: Sequence[float],
    shown: FloatArray | None = None,
) -> tuple[FloatArray, Transform] | None:
    """Return joints (n,), in [rad] or [m], from which the camera looks at a point, and the camera's pose
    base_T_camera (4, 4).

    None if no such joints are found.

    Args:
        robot: robot with a camera on the hand, or elsewhere behind joints of its arm.
        collision: the arm among its surroundings.
        point: (3,) in the base frame, in [m].
        towards: unit vectors (3,) in the base frame from the point to the camera, the best ones first.
        distances: from the camera to the point, in [m], the best ones first; not used for a camera that
            is not on the hand.
        shown: (m, 3) points in the base frame, in [m], that hand, held object and surroundings should not
            hide from a camera on the hand; the first of the views that hide the fewest is taken (default:
            none).
    """
    if robot.view_camera.carrier != HAND_LINK:
        return aimed_joints(robot, collision, point, towards)
    camera_T_hand = inverse(robot.camera.hand_T_camera)
    here, best = robot.arm.command(), None
    fewest = math.inf
    for distance, direction in product(distances, towards):
        for pose in camera_poses(point, direction, distance):
            joints = robot.arm_model.inverse(pose @ camera_T_hand, here, restarts=IK_RESTARTS)
            if joints is None or collision.in_collision(joints):
                continue
            hidden = 0 if shown is None else hidden_count(collision, joints, pose, shown)
            if not hidden:
                return joints, pose
            if hidden < fewest:
                best, fewest = (joints, pose), hidden
    return best
