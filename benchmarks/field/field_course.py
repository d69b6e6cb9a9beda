"""Rows of places at which sensors are to be laid."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from benchmarks.field.placement_radius import TARGET_OFFSET_M
from handcart.robotics.numerics.arrays import FloatArray, IntArray

POINT_SPACING_M = 0.05  # [m] between points of a line


class FieldCourse(NamedTuple):
    """Targets, and the line on which the base drives past them from (0, 0), heading along x."""

    targets: FloatArray
    """(n, 2), in [m]."""
    line: FloatArray
    """(m, 2) dense points of the line [m]; it continues straight past the last stop."""
    stops: IntArray
    """(n,) rows of `line` at which the base stops, with its target on its right."""

    @classmethod
    def through(cls, stops: FloatArray) -> FieldCourse:
        """With straight legs from (0, 0) through the places (n, 2) at which the base stops, in [m]."""
        corners = np.vstack([np.zeros((1, 2)), stops])
        legs = np.diff(corners, axis=0)
        along = legs / np.hypot(*legs.T)[:, None]
        right = np.column_stack([along[:, 1], -along[:, 0]])
        corners = np.vstack([corners, corners[-1] + 3.0 * along[-1]])
        lengths = np.hypot(*np.diff(corners, axis=0).T)
        counts = np.maximum(1, np.round(lengths / POINT_SPACING_M).astype(np.int64))
        pieces = [
            np.linspace(begin, end, count, endpoint=False)
            for begin, end, count in zip(corners[:-1], corners[1:], counts, strict=True)
        ]
        return cls(
            stops + TARGET_OFFSET_M * right, np.vstack([*pieces, corners[-1:]]), np.cumsum(counts[:-1])
        )


def straight_course(count: int = 17, spacing: float = 10.0) -> FieldCourse:
    """Targets in a straight row, `spacing` [m] apart."""
    stops = np.zeros((count, 2))
    stops[:, 0] = spacing * np.arange(1, count + 1)
    return FieldCourse.through(stops)


def zigzag_course(count: int = 7, spacing: float = 10.0, sideways: float = 5.0) -> FieldCourse:
    """Targets in two rows by turns: `spacing` [m] forward, `sideways` [m] across."""
    stops = np.zeros((count, 2))
    stops[:, 0] = spacing * np.arange(1, count + 1)
    stops[1::2, 1] = sideways
    return FieldCourse.through(stops)
