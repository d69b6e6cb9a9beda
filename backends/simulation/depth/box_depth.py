"""True depth of boxes, cylinders and a floor, for all pixels of a pinhole camera."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from handcart.robotics.geometry.transform import Transform, inverse
from handcart.robotics.kinematics.shapes import Box, Cylinder
from handcart.robotics.numerics.arrays import FloatArray, IntArray
from handcart.robotics.perception.cameras.camera_model import CameraModel

NEAREST_M = 0.005
MIN_RAY_COMPONENT = 1e-12
NOTHING, FLOOR = -2, -1
"""Numbers in place of a body's for a pixel that shows nothing, or the floor."""
_CORNERS = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])


Cut = Callable[[FloatArray, FloatArray, FloatArray], tuple[FloatArray, FloatArray]]


class BoxDepth:
    """Ray caster for all pixels of a camera.

    Bodies are boxes and cylinders. Boxes follow the slab method of Kay and Kajiya, "Ray tracing complex
    scenes" (1986); a cylinder is one slab along its axis, bounded by a circle. Only the pixels in the
    rectangle around a body's corners are tested against that body.
    """

    def __init__(self, model: CameraModel) -> None:
        """Prepare the rays of a pinhole camera without distortion."""
        self._K, self._shape = model.K, (model.height, model.width)
        rows, columns = np.indices(self._shape, dtype=np.float64)
        x, y = (columns - model.K[0, 2]) / model.K[0, 0], (rows - model.K[1, 2]) / model.K[1, 1]
        self._rays = np.stack((x, y, np.ones(self._shape)), axis=2)

    def cast(self, world_T_camera: Transform, boxes: Sequence[Box | Cylinder]) -> tuple[FloatArray, IntArray]:
        """Return the depth (h, w) of each pixel, in [m], and the number (h, w) of the body that it shows.

        Args:
            world_T_camera: (4, 4) pose of the optical frame (z forward, x right, y down).
            boxes: bodies besides the floor at height 0; a body that contains the camera is not seen.

        Returns:
            Depth (h, w) along the optical axis, in [m], infinite where nothing is; and the index (h, w) in
            `boxes`, `FLOOR` or `NOTHING`.
        """
        depth, shown = np.full(self._shape, np.inf), np.full(self._shape, NOTHING)
        height, falls = world_T_camera[2, 3], self._rays @ world_T_camera[2, :3]
        with np.errstate(divide="ignore"):
            floor = np.where(falls < 0.0, -height / falls, np.inf)
        met = np.isfinite(floor) & (floor > NEAREST_M)
        depth[met], shown[met] = floor[met], FLOOR
        for number, box in enumerate(boxes):
            size = box.size if isinstance(box, Box) else (2 * box.radius, 2 * box.radius, box.length)
            cut = _cut_box if isinstance(box, Box) else _cut_cylinder
            self._cast(inverse(world_T_camera) @ box.pose, size, cut, number, depth, shown)
        return depth, shown

    def _cast(
        self,
        camera_T_box: Transform,
        size: tuple[float, float, float],
        cut: Cut,
        number: int,
        depth: FloatArray,
        shown: IntArray,
    ) -> None:
        window = self._window(camera_T_box, np.array(size))
        if window is None:
            return
        turn, half = camera_T_box[:3, :3], np.array(size) / 2
        start = -turn.T @ camera_T_box[:3, 3]
        ways = self._rays[window] @ turn
        ways = np.where(np.abs(ways) < MIN_RAY_COMPONENT, MIN_RAY_COMPONENT, ways)
        enter, leave = cut(start, ways, half)
        hit = (enter <= leave) & (enter > NEAREST_M) & (enter < depth[window])
        depth[window] = np.where(hit, enter, depth[window])
        shown[window] = np.where(hit, number, shown[window])

    def _window(self, camera_T_box: Transform, size: FloatArray) -> tuple[slice, slice] | None:
        """Return the rows and columns of pixels that may show a box; None if no pixel does.

        Args:
            camera_T_box: (4, 4) pose of the box's middle in the optical frame.
            size: (3,) lengths along the box's x, y and z, in [m].
        """
        corners = (_CORNERS * size) @ camera_T_box[:3, :3].T + camera_T_box[:3, 3]
        if (corners[:, 2] <= NEAREST_M).all():
            return None
        if (corners[:, 2] <= NEAREST_M).any():
            return slice(None), slice(None)
        pixels = (corners @ self._K.T)[:, :2] / corners[:, 2:]
        (left, top), (right, bottom) = np.floor(pixels.min(axis=0)), np.ceil(pixels.max(axis=0)) + 1
        height, width = self._shape
        if right <= 0 or bottom <= 0 or left >= width or top >= height:
            return None
        return slice(max(0, int(top)), int(bottom)), slice(max(0, int(left)), int(right))


def _cut_box(start: FloatArray, ways: FloatArray, half: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the depths (h, w) at which rays enter and leave a box, in [m] along the optical axis; a ray that
    enters after it leaves misses the box.

    Args:
        start: (3,) position of the camera in the frame of the box's middle, in [m].
        ways: (h, w, 3) rays in that frame, of length 1 along the optical axis.
        half: (3,) half of the box's lengths along x, y and z, in [m].
    """
    one, other = (-half - start) / ways, (half - start) / ways
    return np.minimum(one, other).max(axis=2), np.maximum(one, other).min(axis=2)


def _cut_cylinder(start: FloatArray, ways: FloatArray, half: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the depths (h, w) at which rays enter and leave a cylinder along z, in [m] along the optical
    axis.

    Args:
        start: (3,) position of the camera in the frame of the cylinder's middle, in [m].
        ways: (h, w, 3) rays in that frame, of length 1 along the optical axis.
        half: (3,) radius, radius and half of the length, in [m].
    """
    below, above = (-half[2] - start[2]) / ways[..., 2], (half[2] - start[2]) / ways[..., 2]
    a = (ways[..., :2] ** 2).sum(axis=2)
    b = ways[..., :2] @ start[:2]
    root = b**2 - a * (start[:2] @ start[:2] - half[0] ** 2)
    width = np.sqrt(np.maximum(root, 0.0))
    enter = np.maximum(np.minimum(below, above), (-b - width) / a)
    leave = np.minimum(np.maximum(below, above), (-b + width) / a)
    return np.where(root > 0.0, enter, np.inf), np.where(root > 0.0, leave, -np.inf)
