"""Order in which bodies are painted, so that nearer bodies hide farther ones."""

from __future__ import annotations

from collections.abc import Sequence
from heapq import heapify, heappop, heappush

import numpy as np

from handcart.robotics.kinematics.shapes import Box
from handcart.robotics.numerics.arrays import BoolArray, FloatArray

from .canvas import Canvas
from .painting import SIDE_CORNERS

_TOUCH_M = 2e-3
"""Overlap of two bodies that touch, in [m], up to which a side of one still separates them."""


def painting_order(canvas: Canvas, boxes: Sequence[Box]) -> list[int]:
    """Return the order in which bodies are painted: a body after all those that it hides.

    Two bodies are ordered if their pictures may overlap and a side of one of them separates them: seen
    through the plane of this side, the body on the camera's side is the nearer one (Fuchs, Kedem and Naylor
    1980). All other bodies keep the given order, and so do bodies that hide each other in a circle.

    Args:
        canvas: picture to paint on, with its camera.
        boxes: boxes around the bodies, in the world.
    """
    if not boxes:
        return []
    poses, sizes = np.array([box.pose for box in boxes]), np.array([box.size for box in boxes])
    corners = (SIDE_CORNERS[:2].reshape(-1, 3) * sizes[:, None]) @ poses[:, :3, :3].transpose(0, 2, 1)
    shares_pixels = _overlaps(canvas.rectangles(corners + poses[:, None, :3, 3]))
    cannot_hide = _cannot_hide(poses, sizes / 2, canvas.eye)
    hides = ~cannot_hide & cannot_hide.T & shares_pixels
    if not np.triu(hides).any():
        return list(range(len(boxes)))
    return _sorted(hides)


def _overlaps(rectangles: FloatArray) -> BoolArray:
    """Return which pairs (n, n) of rectangles overlap.

    Args:
        rectangles: (n, 4) least column and row, largest column and row of each, in [px].
    """
    low, high = rectangles[:, :2], rectangles[:, 2:]
    return np.asarray((low[:, None] <= high[None]).all(axis=2) & (low[None] <= high[:, None]).all(axis=2))


def _cannot_hide(poses: FloatArray, halves: FloatArray, eye: FloatArray) -> BoolArray:
    """Return (n, n) for each body a and each body b whether a surely hides no part of b.

    Args:
        poses: (n, 4, 4) poses of the boxes in the world.
        halves: (n, 3) half their sizes, in [m].
        eye: (3,) position of the camera in the world, in [m].
    """
    turns, middles = poses[:, :3, :3], poses[:, :3, 3]
    across = np.einsum("aik,bai->akb", turns, middles[:, None] - middles[None])
    reach = np.einsum("akbj,bj->akb", np.abs(np.einsum("aik,bij->akbj", turns, turns)), halves)
    height = np.einsum("aik,ai->ak", turns, eye - middles)
    edge = halves[:, :, None]
    found = np.zeros((len(poses), len(poses)), bool)
    for beyond, eye_beyond in (
        (across - reach >= edge - _TOUCH_M, height > halves),
        (across + reach <= _TOUCH_M - edge, height < -halves),
    ):
        found |= (beyond & eye_beyond[:, :, None]).any(axis=1)
        found |= (beyond & ~eye_beyond[:, :, None]).any(axis=1).T
    return found


def _sorted(hides: BoolArray) -> list[int]:
    """Return the numbers 0 to n - 1 so that each comes after those that it hides, else in their order.

    Args:
        hides: (n, n) whether body a hides body b.
    """
    waits_for = hides.sum(axis=1)
    ready = np.flatnonzero(waits_for == 0).tolist()
    heapify(ready)
    left, order = set(range(len(hides))), list[int]()
    while left:
        number = heappop(ready) if ready else min(left)  # else they hide each other in a circle
        left.remove(number)
        order.append(number)
        for other in np.flatnonzero(hides[:, number]).tolist():
            waits_for[other] -= 1
            if waits_for[other] == 0 and other in left:
                heappush(ready, other)
    return order
