"""Looks at a spot of a surface, where an object is to be put down."""

from __future__ import annotations

from collections.abc import Generator, Sequence

import cv2
import numpy as np

from handcart.backends.robot.robot import Robot
from handcart.primitives.knowledge.world_model import ModelView
from handcart.primitives.motions.arm_motion import collision_model
from handcart.primitives.objects.files.object_kind import ObjectKind
from handcart.primitives.objects.files.surface import ObjectSurface
from handcart.primitives.objects.holding.placing_plan import FOOT_MARGIN_M
from handcart.primitives.objects.knowledge.aimed_view import sight_line
from handcart.primitives.objects.site.object_site import surroundings
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy
from handcart.primitives.outcomes.evidence import Evidence
from handcart.primitives.restoring.snapshot import settle
from handcart.robotics.geometry.transform import Transform, apply, inverse
from handcart.robotics.numerics.arrays import FloatArray, SingleArray
from handcart.robotics.perception.drawing.overlay import draw_overlay
from handcart.robotics.perception.objects.plain_patch import PictureEdges, is_plain

from .object_look import look_from
from .view_plan import directions

VIEW_DISTANCES_M = (0.32, 0.38, 0.26, 0.46, 0.54)  # the far ones over the rim of a deep box
FAR_VIEW_DISTANCES_M = (*VIEW_DISTANCES_M, 0.64, 0.74)  # for a long object in the hand over a deep box
SIGHT_WIDTH_M = 0.01  # of the line of sight to a point of a spot
VIEW_SPARE = 1.05  # of a view's width over the foot in it
GRID_POINTS = 9  # along each side of a spot, of which those that are hidden are left out
VIEW_POINTS = 5  # likewise, by which a second view is chosen: the first one is chosen by the corners alone
MIN_SEEN_SHARE = 0.4  # of these points: where fewer are seen, nothing is known of the spot
TAKEN, HIDDEN = "something stands there", "walls or known objects hide most of it"
RIM_M = 0.01  # of a surface along its edge, that isn't judged: the edge would be seen as a thing


def why_not_free(
    robot: Robot,
    model: ModelView,
    evidence: Evidence,
    name: str,
    surface: ObjectSurface,
    kind: ObjectKind,
    base_T_goal: Transform,
) -> Generator[None, None, str]:
    """Look at a spot past the held object; return why it isn't known to be free, `TAKEN` or `HIDDEN`.

    The result is empty if the seen part of the spot looks plain, as the surface does.

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
    towards = list(directions((), None, "any"))
    foot, middle = foot_corners(kind, base_T_goal), base_T_goal[:3, 3]
    part = _on_surface(robot, surface, foot)
    for shown, views in ((foot, VIEW_DISTANCES_M), (_points_within(part, VIEW_POINTS), FAR_VIEW_DISTANCES_M)):
        distances = _showing_all(robot, kind, views)
        if not (yield from look_from(robot, model, middle, towards, distances, shown=shown)):
            raise Discrepancy(f"no view of {name} is free", cause=causes.NO_ARM_PATH)
        yield from settle(robot)
        yield
        photo = robot.photo()
        corners = _seen_part(robot, model, photo.base_T_camera, part)
        if corners is not None:
            break
    else:
        return HIDDEN
    share = PictureEdges.of_picture(photo.pixels).share(photo.camera, photo.base_T_camera, corners)
    outline = photo.camera.project(apply(inverse(photo.base_T_camera), corners))
    evidence.pictures["spot"] = draw_overlay(photo.pixels, outlines=[outline])
    return "" if is_plain(share) else TAKEN


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


def _seen_part(
    robot: Robot, model: ModelView, base_T_camera: Transform, corners: FloatArray
) -> FloatArray | None:
    """Return the corners (m, 3) of the part of a spot that no wall and no known object hides; None if it is
    small.

    The rim of a box before the spot would be seen as a thing on it.

    Args:
        robot: robot at the surface.
        model: knows surfaces and objects.
        base_T_camera: (4, 4) pose of the camera.
        corners: (n, 3) corners of the convex spot in the base frame, in [m].
    """
    collision = collision_model(robot, None, surroundings(robot, model))
    points = _points_within(corners, GRID_POINTS)
    seen = [
        point
        for point in points
        if not collision.obstacle_touches(sight_line(base_T_camera, point, SIGHT_WIDTH_M))
    ]
    if len(seen) == len(points):
        return corners
    if len(seen) < MIN_SEEN_SHARE * len(points):
        return None
    return _hull(np.array(seen))


def _points_within(corners: FloatArray, count: int) -> FloatArray:
    """Return points (m, 3) within a convex part of a surface, of a grid around it with `count` points along
    each side; both in the base frame, in [m].
    """
    low, high = corners[:, :2].min(axis=0), corners[:, :2].max(axis=0)
    shares = np.stack(np.meshgrid(*[np.linspace(0.0, 1.0, count)] * 2), axis=-1).reshape(-1, 2)
    outline = corners[:, :2].astype(np.float32)
    inside = [item for item in (low + shares * (high - low)).tolist() if _is_within(outline, item)]
    return np.column_stack([inside, np.full(len(inside), corners[0, 2])])


def _is_within(outline: SingleArray, point: Sequence[float]) -> bool:
    return cv2.pointPolygonTest(outline, (point[0], point[1]), measureDist=False) >= 0.0


def _hull(points: FloatArray) -> FloatArray:
    """Return the corners (m, 3) of the convex hull of points (n, 3) at one height, in the base frame, in
    [m].
    """
    hull = cv2.convexHull(points[:, :2].astype(np.float32)).reshape(-1, 2).astype(np.float64)
    return np.column_stack([hull, np.full(len(hull), points[0, 2])])


def _showing_all(robot: Robot, kind: ObjectKind, distances: Sequence[float]) -> list[float]:
    """Return distances of the camera from a spot, in [m], from which it sees all of an object's foot: the
    given ones, or longer ones.
    """
    camera = robot.view_camera.model
    across = max(kind.size[:2]) + 2 * FOOT_MARGIN_M
    least = VIEW_SPARE * across * float(camera.K[0, 0]) / min(camera.width, camera.height)
    return [max(distance_m, least) for distance_m in distances]
