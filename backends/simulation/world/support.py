"""Supports of a box that is released."""

from __future__ import annotations

import cv2
import numpy as np

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import Transform, inverse
from handcart.robotics.kinematics.shapes import Box
from handcart.robotics.numerics.arrays import FloatArray

from .scene import Scene
from .thing import Rest, Thing

HIGHEST_DROP = 0.01  # onto a support; from higher up a box topples [m]
MAX_PRESSED_DEPTH_M = 0.003  # by which arm and suspension may have pressed it into its support [m]
LEVEL_TOLERANCE_M = 0.001  # supports at most this much apart in height carry together [m]
MIN_UPRIGHT_COSINE = np.cos(np.radians(10.0))
TOPPLED_TILT_RAD = np.radians(10.0)
MAX_SUNK_DEPTH_M = 0.005  # [m] by which a foot may lie below its support, in physics
ROUND_CORNERS = 24  # of the outline of a cylinder
TRAY_LINK = "tray"


def put_down(scene: Scene, thing: Thing) -> None:
    """Drop a box from its current pose.

    Tables, the robot's own table and other things carry the box if they are at most 10 mm below its
    underside. The box then rests flat on them if its middle is within the convex hull of the areas that carry
    it, so it may bridge a gap. Otherwise it falls to the floor and is lost to the robot.
    """
    scene.changes += 1
    thing.rest = Rest.FLOOR
    supports = _supports(scene, thing)
    top = max((height for height, _, _ in supports), default=-np.inf)
    carrying = [(area, own) for height, area, own in supports if height > top - LEVEL_TOLERANCE_M]
    if thing.pose[2, 2] < MIN_UPRIGHT_COSINE or not _within(
        thing.pose[:2, 3], [area for area, _ in carrying]
    ):
        thing.pose = _upright(thing.pose, 0.0)
        return
    thing.pose = _upright(thing.pose, top)
    if any(own for _, own in carrying):
        thing.rest = Rest.TRAY
        thing.base_T_thing = inverse(scene.world_T_base) @ thing.pose
    else:
        thing.rest = Rest.TABLE


def rest_of(scene: Scene, thing: Thing) -> Rest:
    """Return the support of a box that physics has moved: tray, table of the world, open ground, or floor.

    A box on another box has the other box's support. A toppled box counts as on the floor, lost to the
    robot, wherever it lies. A box on sloping ground is upright if it is aligned with the ground.
    """
    toppled = thing.tilt() > TOPPLED_TILT_RAD
    if not toppled and scene.robot.has_tray:
        tray = scene.robot.tray_shape
        x, y, z = (inverse(scene.world_T_base) @ thing.pose)[:3, 3]
        beside = np.abs(np.array((x, y)) - tray.middle) - np.array(tray.size[:2]) / 2
        if (beside < 0.0).all() and z > tray.top - MAX_SUNK_DEPTH_M:
            return Rest.TRAY
    for solid in [] if toppled else scene.solids:
        x, y, z = (inverse(solid.box.pose) @ thing.pose)[:3, 3]
        length, width, height = solid.box.size
        if abs(x) < length / 2 and abs(y) < width / 2 and z > height / 2 - MAX_SUNK_DEPTH_M:
            return Rest.TABLE
    return Rest.TABLE if scene.open_ground and _stands_on_ground(scene, thing) else Rest.FLOOR


def _stands_on_ground(scene: Scene, thing: Thing) -> bool:
    """Return whether a thing is on its foot, parallel to the ground below it."""
    x, y, z = thing.pose[:3, 3]
    half = max(thing.size[:2]) / 2
    ahead, behind, left, right = (
        scene.ground_height(x + dx, y + dy)
        for dx, dy in ((half, 0.0), (-half, 0.0), (0.0, half), (0.0, -half))
    )
    normal = np.array([behind - ahead, right - left, 2.0 * half])
    upright = float(thing.pose[:3, 2] @ normal / np.linalg.norm(normal))
    return upright > float(np.cos(TOPPLED_TILT_RAD)) and bool(
        z > scene.ground_height(x, y) - MAX_SUNK_DEPTH_M
    )


def _supports(scene: Scene, thing: Thing) -> list[tuple[float, FloatArray, bool]]:
    """Return the upper sides right below a thing.

    Each is its height in [m], the outline (n, 2) of the contact in the world in [m], and True if it is on the
    robot.
    """
    foot = float(thing.pose[2, 3])
    outline = _round_outline(thing) if thing.is_round else _outline(Box(thing.pose, thing.size))
    boxes = [(solid.box, False) for solid in scene.solids]
    boxes += [
        (item.box(), item.rest is Rest.TRAY)
        for item in scene.things()
        if item is not thing and item.rest in (Rest.TABLE, Rest.TRAY)
    ]
    if scene.robot.has_tray:
        tray = scene.robot.tray_shape
        pose = scene.base.compose(Pose2(*tray.middle, 0.0)).lift(tray.top - tray.size[2] / 2)
        boxes.append((Box(pose, tray.size, TRAY_LINK), True))
    found = []
    for box, own in boxes:
        top = float(box.pose[2, 3]) + box.size[2] / 2
        if -HIGHEST_DROP <= top - foot <= MAX_PRESSED_DEPTH_M:
            area = cv2.intersectConvexConvex(outline.astype(np.float32), _outline(box).astype(np.float32))[1]
            if area is not None and len(area) >= 3:
                found.append((top, area.reshape(-1, 2).astype(np.float64), own))
    return found


def _outline(box: Box) -> FloatArray:
    """Return the corners (4, 2) of an upright box on the floor, x and y in the world, in [m]."""
    half = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]]) * np.array(box.size[:2]) / 2
    return np.asarray(half @ box.pose[:2, :2].T + box.pose[:2, 3])


def _round_outline(thing: Thing) -> FloatArray:
    """Return points (n, 2) around the foot of a cylinder, x and y in the world, in [m]."""
    angles = np.arange(ROUND_CORNERS) * (2.0 * np.pi / ROUND_CORNERS)
    return np.asarray(
        thing.size[0] / 2 * np.column_stack([np.cos(angles), np.sin(angles)]) + thing.pose[:2, 3]
    )


def _within(middle: FloatArray, areas: list[FloatArray]) -> bool:
    if not areas:
        return False
    # Metres from the middle, for single precision.
    corners = (np.vstack(areas) - middle).astype(np.float32)
    return cv2.pointPolygonTest(cv2.convexHull(corners), (0.0, 0.0), measureDist=False) > 0


def _upright(pose: Transform, height: float) -> Transform:
    yaw = float(np.arctan2(pose[1, 0], pose[0, 0]))
    return Pose2(float(pose[0, 3]), float(pose[1, 3]), yaw).lift(height)
