"""Pairs of bodies that are close enough for an exact contact test."""

from __future__ import annotations

import numpy as np

from handcart.robotics.numerics.arrays import BoolArray, FloatArray, IntArray
from handcart.robotics.numerics.compiled import compiled_for


class Boxes:
    """Poses and sizes of many boxes, stored as arrays for fast distance tests."""

    def __init__(self, sizes: FloatArray, poses: FloatArray) -> None:
        """Take in n boxes.

        Args:
            sizes: (n, 3) lengths along x, y and z, in [m].
            poses: (n, 4, 4) world_T_box of the boxes' middles.
        """
        self.middles = np.ascontiguousarray(poses[:, :3, 3])
        self.turns = np.ascontiguousarray(poses[:, :3, :3])
        self.halves = 0.5 * sizes

    def place(self, number: int, size: FloatArray, pose: FloatArray) -> None:
        """Replace a box by another one.

        Args:
            number: index of the box.
            size: (3,) lengths along x, y and z, in [m].
            pose: (4, 4) world_T_box of the box's middle.
        """
        self.middles[number], self.turns[number] = pose[:3, 3], pose[:3, :3]
        self.halves[number] = 0.5 * size


def near_boxes(poses: FloatArray, radii: FloatArray, boxes: Boxes, there: BoolArray) -> IntArray:
    """Return the pairs (m, 2) of bodies and boxes in which the body's bounding sphere meets the box.

    A row holds the index of the body and the index of the box.

    Args:
        poses: (b, 4, 4) poses of the bodies, in the frame of the boxes.
        radii: (b,) radii of the bodies' bounding spheres about their origins, in [m].
        boxes: n boxes.
        there: (n,) True for boxes that are present.
    """
    return _near_boxes(poses, radii, boxes.middles, boxes.turns, boxes.halves, there)


@compiled_for("(f8[:,:,::1], f8[::1], f8[:,:,::1], f8[::1])")
def near_spheres(
    poses: FloatArray, radii: FloatArray, others: FloatArray, other_radii: FloatArray
) -> IntArray:
    """Return the pairs (m, 2) of bodies of two groups whose bounding spheres meet.

    A row holds the index of a body of the first group and the index of a body of the second group.

    Args:
        poses: (b, 4, 4) poses of the first group, in any common frame.
        radii: (b,) radii of the first group's bounding spheres about the bodies' origins, in [m].
        others: (n, 4, 4) poses of the second group, in the same frame.
        other_radii: (n,) radii of the second group's bounding spheres, in [m].
    """
    pairs = np.empty((len(radii) * len(other_radii), 2), dtype=np.int64)
    count = 0
    for i in range(len(radii)):
        for j in range(len(other_radii)):
            x = poses[i, 0, 3] - others[j, 0, 3]
            y = poses[i, 1, 3] - others[j, 1, 3]
            z = poses[i, 2, 3] - others[j, 2, 3]
            if x * x + y * y + z * z < (radii[i] + other_radii[j]) ** 2:
                pairs[count, 0], pairs[count, 1] = i, j
                count += 1
    return pairs[:count]


@compiled_for("(f8[:,:,::1], f8[::1], f8[:,::1], f8[:,:,::1], f8[:,::1], b1[::1])")
def _near_boxes(
    poses: FloatArray,
    radii: FloatArray,
    middles: FloatArray,
    turns: FloatArray,
    halves: FloatArray,
    there: BoolArray,
) -> IntArray:
    pairs = np.empty((len(radii) * len(there), 2), dtype=np.int64)
    count = 0
    for i in range(len(radii)):
        for j in range(len(there)):
            if not there[j]:
                continue
            x = poses[i, 0, 3] - middles[j, 0]
            y = poses[i, 1, 3] - middles[j, 1]
            z = poses[i, 2, 3] - middles[j, 2]
            outside = 0.0
            for k in range(3):
                along = abs(turns[j, 0, k] * x + turns[j, 1, k] * y + turns[j, 2, k] * z) - halves[j, k]
                if along > 0.0:
                    outside += along * along
            if outside < radii[i] ** 2:
                pairs[count, 0], pairs[count, 1] = i, j
                count += 1
    return pairs[:count]
