"""Order in which the blocks of a drawing can be laid: each after its supports."""

from __future__ import annotations

import heapq
import math
from collections.abc import Callable, Iterator, Sequence

import cv2
import numpy as np

from handcart.files.errors import Finding
from handcart.files.models.loading import Loaded
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.numerics.arrays import FloatArray

from .drawing import Drawing, DrawnBlock
from .supports import SUPPORT_TOLERANCE_M

MIN_SUPPORT_MARGIN_M = 0.003  # by which a block's middle lies inside of what carries it
MAX_OVERLAP_M2 = 1e-6  # of overlap that two blocks may have

Rectangle = tuple[tuple[float, float], tuple[float, float], float]


def wall_findings(loaded: Loaded[Drawing]) -> Iterator[Finding]:
    """Yield a finding for each fault that makes a drawing impossible to build: overlapping blocks, blocks
    without support, or too few blocks in the supply.
    """
    drawing = loaded.value
    blocks, (length, width, height) = drawing.blocks, drawing.block
    for number, block in enumerate(blocks):
        own = _rectangle(block.place.floor, length, width)
        for other in blocks[:number]:
            level = abs(other.place.height_m - block.place.height_m) < height - SUPPORT_TOLERANCE_M
            if level and _area(_common(own, _rectangle(other.place.floor, length, width))) > MAX_OVERLAP_M2:
                wrong = f"{block.words} stands in {other.words}; allowed: blocks beside each other"
                yield loaded.finding(block.key, wrong)
        ground = _carrying(drawing, block, blocks)
        if not len(ground):
            wrong = (
                f"nothing carries {block.words}: no table and no block ends {block.place.height_m:g} m high"
            )
            yield loaded.finding(block.key, f"{wrong} below it; needed: one")
        elif _inside(ground, block.place.floor) < MIN_SUPPORT_MARGIN_M:
            wrong = f"{block.words} tips over: its middle lies beside what carries it"
            yield loaded.finding(block.key, f"{wrong}; needed: support on both sides of it")
    if len(drawing.supply) < len(blocks):
        wrong = f"{len(drawing.supply)} blocks wait for a wall of {len(blocks)}; needed: one for each"
        yield loaded.finding(("supply",), wrong)


def laying_orders(drawing: Drawing) -> list[list[DrawnBlock]]:
    """Return the possible orders in which to lay the blocks of a wall, from bottom to top.

    One order finishes each row before the next one; the other finishes the wall's full height at one end
    first, and goes on along the wall. Equal orders are returned once.
    """
    blocks = drawing.blocks
    ends = np.array([block.place.floor[:2] for block in blocks])
    _, _, axes = np.linalg.svd(ends - ends.mean(axis=0))
    along = (ends - ends.mean(axis=0)) @ axes[0]
    by_rows = {block: (block.place.height_m, at) for block, at in zip(blocks, along.tolist(), strict=True)}
    in_steps = {block: (at, block.place.height_m) for block, at in zip(blocks, along.tolist(), strict=True)}
    orders = [_order(drawing, blocks, rank.__getitem__) for rank in (by_rows, in_steps)]
    return orders[:1] if orders[0] == orders[1] else orders


def _order(
    drawing: Drawing, blocks: Sequence[DrawnBlock], rank: Callable[[DrawnBlock], tuple[float, float]]
) -> list[DrawnBlock]:
    """Return the blocks in laying order: repeatedly the first by rank whose supports are laid."""
    below = {
        block: [drawn_block for drawn_block in blocks if _carries(drawing, drawn_block, block)]
        for block in blocks
    }
    laid, waiting = list[DrawnBlock](), [(rank(block), block) for block in blocks if not below[block]]
    heapq.heapify(waiting)
    while waiting:
        laid.append(heapq.heappop(waiting)[1])
        for block in blocks:
            if laid[-1] in below[block] and set(below[block]) <= set(laid):
                heapq.heappush(waiting, (rank(block), block))
    return laid


def _carries(drawing: Drawing, lower: DrawnBlock, upper: DrawnBlock) -> bool:
    length, width, height = drawing.block
    if abs(lower.place.height_m + height - upper.place.height_m) > SUPPORT_TOLERANCE_M:
        return False
    feet = (_rectangle(item.place.floor, length, width) for item in (lower, upper))
    return _area(_common(*feet)) > MAX_OVERLAP_M2


def _carrying(drawing: Drawing, block: DrawnBlock, blocks: Sequence[DrawnBlock]) -> FloatArray:
    """Return the corners (n, 2) of the areas that carry a block, in [m]."""
    length, width, _ = drawing.block
    foot = _rectangle(block.place.floor, length, width)
    under = [_rectangle(b.place.floor, length, width) for b in blocks if _carries(drawing, b, block)]
    tables = [
        t for t in drawing.tables.values() if abs(t.height_m - block.place.height_m) < SUPPORT_TOLERANCE_M
    ]
    under += [_rectangle(table.floor, *table.size_m) for table in tables]
    return np.vstack([np.empty((0, 2)), *(_common(foot, rectangle) for rectangle in under)])


def _rectangle(floor: Pose2, length: float, width: float) -> Rectangle:
    return (floor.x, floor.y), (length, width), math.degrees(floor.theta)


def _common(one: Rectangle, other: Rectangle) -> FloatArray:
    """Return the corners (n, 2) of the intersection of two rectangles, in [m]."""
    middle = np.array(one[0])  # near the origin, because OpenCV computes in single precision
    beside = (other[0][0] - one[0][0], other[0][1] - one[0][1])
    found, corners = cv2.rotatedRectangleIntersection(((0.0, 0.0), *one[1:]), (beside, *other[1:]))
    if found == cv2.INTERSECT_NONE:
        return np.empty((0, 2))
    return np.asarray(np.asarray(corners, dtype=np.float64).reshape(-1, 2) + middle)


def _area(corners: FloatArray) -> float:
    if len(corners) < 3:
        return 0.0
    return float(cv2.contourArea(cv2.convexHull((corners - corners[0]).astype(np.float32))))


def _inside(corners: FloatArray, floor: Pose2) -> float:
    """Return the distance of a pose inside the hull of corners (n, 2), in [m]; negative outside."""
    hull = cv2.convexHull((corners - floor[:2]).astype(np.float32))
    return float(cv2.pointPolygonTest(hull, (0.0, 0.0), True))
