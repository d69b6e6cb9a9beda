"""Relations between bodies by their true poses, as BEHAVIOR-1K's simulator defines them.

Definitions: OmniGibson, omnigibson/object_states: on_top.py, inside.py, next_to.py, under.py, adjacency.py.
There rays from a body find its neighbours; all bodies here are boxes, so each ray is computed. Since 2026
`inside` asks for the volume between an object's walls instead; for our furniture that is the same.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from handcart.robotics.geometry.footprint import polygon_gap
from handcart.robotics.geometry.transform import inverse
from handcart.robotics.kinematics.shapes import Box, corners
from handcart.robotics.numerics.arrays import FloatArray

RAY_M = 5.0
AXES = 5
"""Pairs of level axes that are tried, spread over a quarter turn."""
NEAR_DIRECTIONS = 10  # level directions in which a neighbour is looked for
NEAR_SHARE = 1.0 / 6.0  # of the mean size of two bodies next to each other
TOUCH_M = 0.005
UP = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True, eq=False)
class TrueThing:
    """A thing of an activity: the solid boxes that it consists of, posed in the world."""

    term: str
    solids: tuple[Box, ...]

    @property
    def points(self) -> FloatArray:
        """Corners (n, 3) of all solids of the thing, in the world, in [m]."""
        return np.vstack([corners(solid) for solid in self.solids])

    @property
    def extent(self) -> tuple[FloatArray, FloatArray]:
        """Lower and upper corner (3,) of the level box around the thing, in the world in [m]."""
        return self.points.min(axis=0), self.points.max(axis=0)

    @property
    def middle(self) -> FloatArray:
        """Middle (3,) of the level box around the thing, in the world in [m]."""
        low, high = self.extent
        return np.asarray((low + high) / 2)

    def is_hit(self, start: FloatArray, direction: FloatArray) -> bool:
        """Return whether a ray of length `RAY_M` meets the thing.

        Args:
            start: (3,) begin of the ray in the world, in [m].
            direction: (3,) unit vector in the world.
        """
        return any(_meets(solid, start, direction) for solid in self.solids)


def is_on_top(upper: TrueThing, lower: TrueThing) -> bool:
    """Return whether two things touch, `lower` has a part straight below `upper`, and no part straight above
    it.
    """
    if not is_touching(upper, lower):
        return False
    below, above = _vertical_starts(upper)
    return lower.is_hit(below, -UP) and not lower.is_hit(above, UP)


def is_under(lower: TrueThing, upper: TrueThing) -> bool:
    """Return whether a vertical line upwards from `lower` meets `upper`.

    Return False if `upper` also has a part below `lower`, or `lower` has a part above `upper`.
    """
    below, above = _vertical_starts(lower)
    _, over = _vertical_starts(upper)
    return upper.is_hit(above, UP) and not upper.is_hit(below, -UP) and not lower.is_hit(over, UP)


def is_inside(inner: TrueThing, outer: TrueThing) -> bool:
    """Return whether the middle of `inner` is within the level box around `outer`, and between parts of it.

    Parts of `outer` have to be on both sides of `inner` along two axes: the vertical and a level one, or two
    level ones.
    """
    middle, (low, high) = inner.middle, outer.extent
    if not ((low <= middle) & (middle <= high)).all():
        return False
    below, above = _vertical_starts(inner)
    between = [[_is_between(outer, middle, axis) for axis in axes] for axes in _level_axes()]
    if outer.is_hit(below, -UP) and outer.is_hit(above, UP):
        return any(item for pair in between for item in pair)
    return any(all(pair) for pair in between)


def is_next_to(one: TrueThing, other: TrueThing) -> bool:
    """Return whether two things are side by side, with a gap of at most `NEAR_SHARE` times the mean of their
    summed sizes along x, y and z.
    """
    (low, high), (other_low, other_high) = one.extent, other.extent
    apart = np.maximum(0.0, np.maximum(low, other_low) - np.minimum(high, other_high))
    mean = float(np.mean((high - low) + (other_high - other_low)))
    if float(np.linalg.norm(apart)) > NEAR_SHARE * mean:
        return False
    return _is_beside(one, other) or _is_beside(other, one)


def is_touching(one: TrueThing, other: TrueThing) -> bool:
    """Return whether two things are in contact, within `TOUCH_M`."""
    return any(_gap(a, b) <= TOUCH_M for a in one.solids for b in other.solids)


def _is_beside(one: TrueThing, other: TrueThing) -> bool:
    middle = one.middle
    angles = np.arange(NEAR_DIRECTIONS) * (2.0 * np.pi / NEAR_DIRECTIONS)
    return any(other.is_hit(middle, np.array([np.cos(angle), np.sin(angle), 0.0])) for angle in angles)


def _is_between(outer: TrueThing, point: FloatArray, axis: FloatArray) -> bool:
    return outer.is_hit(point, axis) and outer.is_hit(point, -axis)


def _level_axes() -> Iterator[tuple[FloatArray, FloatArray]]:
    for angle in np.linspace(0.0, np.pi / 2, AXES):
        first = np.array([np.cos(angle), np.sin(angle), 0.0])
        yield first, np.cross(UP, first)


def _vertical_starts(thing: TrueThing) -> tuple[FloatArray, FloatArray]:
    """Return the points (3,) below and above the middle of a thing, on its surface."""
    low, high = thing.extent
    middle = thing.middle
    return np.array([*middle[:2], low[2]]), np.array([*middle[:2], high[2]])


def _meets(box: Box, start: FloatArray, direction: FloatArray) -> bool:
    to_box = inverse(box.pose)
    origin, along = to_box[:3, :3] @ start + to_box[:3, 3], to_box[:3, :3] @ direction
    half = np.array(box.size) / 2
    with np.errstate(divide="ignore", invalid="ignore"):
        ends = np.stack([(-half - origin) / along, (half - origin) / along])
    parallel = np.abs(along) < 1e-12
    if bool((parallel & (np.abs(origin) > half)).any()):
        return False
    near = np.where(parallel, -np.inf, ends.min(axis=0)).max()
    far = np.where(parallel, np.inf, ends.max(axis=0)).min()
    return bool(near <= far and far >= 0.0 and near <= RAY_M)


def _gap(one: Box, other: Box) -> float:
    """Return the distance of two upright boxes, in [m]; 0 where they overlap."""
    (low, high), (other_low, other_high) = (TrueThing("", (item,)).extent for item in (one, other))
    vertical = max(0.0, low[2] - other_high[2], other_low[2] - high[2])
    level = max(0.0, polygon_gap(_outline(one), _outline(other)))
    return float(np.hypot(vertical, level))


def _outline(box: Box) -> FloatArray:
    """Return the corners (4, 2) of a box seen from above, in the world in [m]; of a tilted one, those of the
    box around it.
    """
    if box.pose[2, 2] > 0.999:
        half = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]]) * np.array(box.size[:2]) / 2
        return np.asarray(half @ box.pose[:2, :2].T + box.pose[:2, 3])
    low, high = TrueThing("", (box,)).extent
    return np.array([[high[0], high[1]], [low[0], high[1]], [low[0], low[1]], [high[0], low[1]]])
