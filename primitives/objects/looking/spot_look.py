"""Looks at a spot of a surface, where an object is to be put down."""

from __future__ import annotations

from collections.abc import Generator

import cv2
import numpy as np

from handcart.backends.robot.robot import Robot
from handcart.primitives.knowledge.world_model import ModelView
from handcart.primitives.objects.files.object_kind import ObjectKind
from handcart.primitives.objects.files.surface import ObjectSurface
from handcart.primitives.objects.holding.placing_plan import FOOT_MARGIN_M
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy
from handcart.primitives.outcomes.evidence import Evidence
from handcart.primitives.restoring.snapshot import settle
from handcart.robotics.geometry.transform import Transform, apply, inverse
from handcart.robotics.numerics.arrays import FloatArray
from handcart.robotics.perception.drawing.overlay import draw_overlay
from handcart.robotics.perception.objects.plain_patch import PictureEdges, is_plain

from .object_look import look_from
from .view_plan import directions

VIEW_DISTANCES_M = (0.32, 0.38, 0.26, 0.46, 0.54)  # the far ones over the rim of a deep box
VIEW_SPARE = 1.05  # of a view's width over the foot in it
RIM_M = 0.01  # of a surface along its edge, that isn't judged: the edge would be seen as a thing


def is_spot_free(
    robot: Robot,
    model: ModelView,
    evidence: Evidence,
    name: str,
    surface: ObjectSurface,
    kind: ObjectKind,
    base_T_goal: Transform,
) -> Generator[None, None, bool]:
    """Look at a spot past the held object; return whether it looks plain, as the surface does.

    Args:
        robot: robot with an object in its hand.
        model: knows surfaces and objects.
        evidence: receives the picture.
        name: name of the surface, for messages.
        surface: the surface.
        kind: kind of the held object.
        base_T_goal: (4, 4) pose of the object at the spot.

    Raises:
        Discrepancy: no view of the spot is free.
    """
    towards, distances = list(directions((), None, "any")), _showing_all(robot, kind)
    foot, middle = foot_corners(kind, base_T_goal), base_T_goal[:3, 3]
    if not (yield from look_from(robot, model, middle, towards, distances, shown=foot)):
        raise Discrepancy(f"no view of {name} is free", cause=causes.NO_ARM_PATH)
    yield from settle(robot)
    yield
    photo, corners = robot.photo(), _on_surface(robot, surface, foot)
    share = PictureEdges.of_picture(photo.pixels).share(photo.camera, photo.base_T_camera, corners)
    outline = photo.camera.project(apply(inverse(photo.base_T_camera), corners))
    evidence.pictures["spot"] = draw_overlay(photo.pixels, outlines=[outline])
    return is_plain(share)


def foot_corners(kind: ObjectKind, base_T_goal: Transform) -> FloatArray:
    """Return (4, 3) corners around an object's foot with a margin, in the base frame, in [m]."""
    half = np.array([kind.size[0], kind.size[1]]) / 2 + FOOT_MARGIN_M
    flat = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]]) * half
    return apply(base_T_goal, np.column_stack([flat, np.zeros(4)]))


def _on_surface(robot: Robot, surface: ObjectSurface, corners: FloatArray) -> FloatArray:
    """Return the corners (m, 3) of the part of a foot (n, 3) that is on a surface and not along its edge.

    The complete foot is returned if no part of it is, because the surface isn't where it is thought to be.
    """
    to_base = robot.pose.relative_to(surface.floor)
    half = np.array(surface.size_m) / 2 - RIM_M
    top = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]]) * half
    foot = to_base.apply(corners[:, :2])
    area, common = cv2.intersectConvexConvex(foot.astype(np.float32), top.astype(np.float32))
    if area <= 0.0 or common is None:
        return corners
    flat = to_base.inverse().apply(np.asarray(common.reshape(-1, 2), dtype=np.float64))
    return np.column_stack([flat, np.full(len(flat), corners[0, 2])])


def _showing_all(robot: Robot, kind: ObjectKind) -> list[float]:
    """Return distances of the camera from a spot, in [m], from which it sees all of an object's foot."""
    camera = robot.view_camera.model
    across = max(kind.size[:2]) + 2 * FOOT_MARGIN_M
    least = VIEW_SPARE * across * float(camera.K[0, 0]) / min(camera.width, camera.height)
    return [max(distance_m, least) for distance_m in VIEW_DISTANCES_M]
