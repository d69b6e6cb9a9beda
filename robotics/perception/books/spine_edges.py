"""Edges that run up the shelf's front: where spines end, by line fits through strips of a flat view."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from handcart.robotics.numerics.arrays import FloatArray
from handcart.robotics.numerics.compiled import compiled
from handcart.robotics.perception.books.flat_view import FlatView

_STRIP_ROWS = 10
_STEEPEST, _TILTS = 0.05, 41  # tangents of tilt that are tried
_REACH = 4  # columns on each side of an edge that are compared
_LEAST_DROP, _LEAST_RELATIVE_DROP = 7.0, 0.14
_COVERAGE, _FEWEST_STRIPS = 0.75, 12
_APART = 7  # columns
_SEAM_COLUMNS, _BRIGHTENS = (
    8,
    0.25,
)  # behind a seam: how far is looked, and by which share of the spine's grey
_SEAM = 0.0018  # [m] between the spines of two books that touch, or spine and cover, at most


class Strips(NamedTuple):
    """Horizontal strips of a picture that was rectified to the shelf's front, each averaged over some rows.

    `grey` (n, w) are the grey levels of n strips, NaN where not visible. Strip i is at height z[i]. Column c
    shows y = left + sign * c * m_per_px, with sign -1 as seen from the front, +1 if mirrored. `z`, `left` and
    y are in [m], in the shelf frame.
    """

    grey: FloatArray
    z: FloatArray
    left: float
    m_per_px: float
    sign: int

    def mirrored(self) -> Strips:
        """Return the strips of the picture mirrored, so that their columns run from right to left."""
        last = self.left + self.sign * (self.grey.shape[1] - 1) * self.m_per_px
        return Strips(self.grey[:, ::-1], self.z, last, self.m_per_px, -self.sign)

    def lateral(self, column: float) -> float:
        """Return the position y in the shelf frame, in [m], of a column of a strip of the picture, in [px].

        Strips are horizontal and run along the shelf.
        """
        return self.left + self.sign * column * self.m_per_px

    def above(self, height: float) -> Strips:
        """Return the strips (rows of grey levels, each at one height of the shelf) above a height in the
        shelf frame, in [m].
        """
        return self._replace(grey=self.grey[self.z > height], z=self.z[self.z > height])

    def at(self, y: FloatArray) -> FloatArray:
        """Return the grey levels (n, m) of all strips, 0 to 255; NaN where the view shows nothing.

        Args:
            y: (m,) lateral positions in the shelf frame, in [m].
        """
        columns = (y - self.left) * self.sign / self.m_per_px
        inside = (columns >= 0.0) & (columns < self.grey.shape[1] - 1)
        below = np.where(inside, columns, 0.0).astype(int)
        grey = self.grey[:, below] + (columns - below) * (self.grey[:, below + 1] - self.grey[:, below])
        return np.where(inside, grey, np.nan)

    def brightness(self, left: float, right: float, lowest: float) -> float | None:
        """Return the typical grey level of a lateral interval; None if more than half of it is not visible.

        It is the median of the mean grey levels that the strips above a height have in the interval.

        Args:
            left: left end y in the shelf frame, in [m].
            right: right end y in the shelf frame, in [m].
            lowest: height in the shelf frame above which strips count, in [m].
        """
        part = self._part(left, right)[self.z > lowest]
        seen = ~np.isnan(part)
        if part.size == 0 or seen.mean() < 0.5:
            return None
        return float(np.median(np.nanmean(part[seen.any(axis=1)], axis=1)))

    def seen(self, left: float, right: float, highest: float) -> float:
        """Return which share, 0 to 1, of an area of the strips is visible.

        The area is from y = `left` to y = `right`, and lower than z = `highest`, in the shelf frame in [m].
        """
        part = self._part(left, right)[self.z < highest]
        return float(np.mean(~np.isnan(part))) if part.size else 0.0

    def _part(self, left: float, right: float) -> FloatArray:
        ends = sorted(round((y - self.left) * self.sign / self.m_per_px) for y in (left, right))
        return self.grey[:, max(0, ends[0]) : max(0, ends[1] + 1)]


class SpineEdge(NamedTuple):
    """Vertical edge in a flat view of the shelf.

    `y` is its position in the shelf frame at the view's mean height, in [m]. `drop` is the decrease of grey
    there, in grey levels. `coverage`, 0 to 1, is the share of the view's height over which the edge was
    found.
    """

    y: float
    drop: float
    coverage: float


def strips_of(view: FlatView) -> Strips:
    """Divide a view of the shelf's front into horizontal strips, each the average of rows over a few
    millimetres.

    The view is flat, which means without perspective.
    """
    count = view.picture.shape[0] // _STRIP_ROWS
    shape = (count, _STRIP_ROWS, view.picture.shape[1])
    rows = slice(0, count * _STRIP_ROWS)
    grey = view.picture[rows].reshape(shape).astype(np.float64).mean(axis=1)
    grey[~view.seen[rows].reshape(shape).all(axis=1)] = np.nan
    z = view.top - (np.arange(count) + 0.5 - 0.5 / _STRIP_ROWS) * _STRIP_ROWS * view.m_per_px
    return Strips(grey, z, view.left, view.m_per_px, -1)


def upright(strips: Strips) -> Strips:
    """Return horizontal strips of a picture of books, shifted sideways against each other, so that the books'
    edges are upright.

    This corrects a small roll of the camera. Of several tilts, the one is chosen at which the edges in all
    strips are best in line. Positions at the mean height are unchanged.
    """
    tilts = np.linspace(-_STEEPEST, _STEEPEST, _TILTS)
    slopes = np.nan_to_num(strips.grey[:, 2:] - strips.grey[:, :-2])
    # A label's rim is short but strong; an edge that counts is long.
    slopes = np.clip(slopes, -25.0, 25.0)
    scores = [float((_sheared(slopes, strips, tilt).mean(axis=0) ** 2).sum()) for tilt in tilts]
    return strips._replace(grey=_sheared(strips.grey, strips, float(tilts[int(np.argmax(scores))])))


def _sheared(rows: FloatArray, strips: Strips, tilt: float) -> FloatArray:
    return _shifted(np.ascontiguousarray(rows), tilt * (strips.z - strips.z.mean()) / strips.m_per_px)


@compiled
def _shifted(rows: FloatArray, shifts: FloatArray) -> FloatArray:
    """Return each row (w,) read at columns shifted by `shifts`, with linear interpolation as `np.interp`; 0
    outside.
    """
    count, width = rows.shape
    out = np.zeros((count, width))
    for i in range(count):
        for k in range(width):
            at = k + shifts[i]
            if not 0.0 <= at <= width - 1:
                continue
            j = math.floor(at)
            if j == at:
                out[i, k] = rows[i, j]
            else:
                out[i, k] = (rows[i, j + 1] - rows[i, j]) * (at - j) + rows[i, j]
    return out


def falling_edges(strips: Strips) -> list[SpineEdge]:
    """Return edges at which the grey level decreases from one column to the next, over most of the visible
    height.
    """
    grey, width = strips.grey, strips.grey.shape[1]
    before = grey[:, : -2 * _REACH]
    # The darkest beyond: between two spines that touch there is but a seam, and the next one may be the
    # brighter.
    beyond = [grey[:, _REACH + k : width - _REACH + k] for k in range(1, _REACH + 1)]
    drop = before - np.minimum.reduce(beyond)
    seen = ~np.isnan(drop)
    falls = seen & (drop > np.maximum(_LEAST_DROP, _LEAST_RELATIVE_DROP * before))
    enough = seen.sum(axis=0) >= _FEWEST_STRIPS
    coverage = np.where(enough, falls.sum(axis=0) / np.maximum(seen.sum(axis=0), 1), 0.0)
    strength = (
        coverage * np.where(seen, np.clip(drop, 0.0, 40.0), 0.0).sum(axis=0) / np.maximum(seen.sum(axis=0), 1)
    )
    edges = []
    for column in _peaks(strength, coverage):
        fitted = _fit(strips, column + _REACH)
        if fitted is not None and 0 < fitted < width - 1:
            y = strips.lateral(fitted + _to_seam(grey, fitted))
            edges.append(SpineEdge(y, float(np.nanmean(drop[:, column])), float(coverage[column])))
    return edges


def _to_seam(grey: FloatArray, column: float) -> float:
    """Return the number of columns from the steepest fall to the darkest line behind it; 0 if the grey does
    not rise again after that line: a spine ends where it is darkest.
    """
    near = grey[:, int(column) : int(column) + _SEAM_COLUMNS]
    if near.shape[1] < _SEAM_COLUMNS or np.isnan(near).all(axis=0).any():
        return 0.0
    profile = _medians(near)
    darkest = int(np.argmin(profile[:-2]))
    brightens = profile[darkest:].max() - profile[darkest]
    if darkest == 0 or brightens < max(_LEAST_DROP, _BRIGHTENS * profile[0]):
        return 0.0
    a, b, c = profile[darkest - 1 : darkest + 2]
    return float(darkest + 0.5 * (a - c) / max(a - 2 * b + c, 1e-9) - column % 1.0)


def _medians(values: FloatArray) -> FloatArray:
    """Median (n,) of each column (m, n) without its NaN; numpy's `nanmedian` takes ten times as long."""
    ordered = np.sort(values, axis=0)  # NaN last
    counts, columns = np.count_nonzero(~np.isnan(values), axis=0), np.arange(values.shape[1])
    return np.asarray(0.5 * (ordered[(counts - 1) // 2, columns] + ordered[counts // 2, columns]))


def all_sides(strips: Strips) -> list[float]:
    """Return y of all edges in the shelf frame, in [m], at which the grey level falls or rises.

    A rise close behind a fall is the dark seam between the sides of two books; both count as one edge.
    """
    sides = []
    rises = sorted((edge.y for edge in falling_edges(strips.mirrored())), reverse=True)
    for fall in sorted((edge.y for edge in falling_edges(strips)), reverse=True):
        rise = next((y for y in rises if 0.0 <= fall - y < _SEAM), None)
        if rise is not None:
            rises.remove(rise)
        sides.append(fall if rise is None else (fall + rise) / 2)
    return [*sides, *rises]


def _peaks(strength: FloatArray, coverage: FloatArray) -> list[int]:
    """Columns of local maxima, at least _APART from a stronger one."""
    chosen: list[int] = []
    candidates = np.flatnonzero(coverage >= _COVERAGE)
    for column in candidates[np.argsort(-strength[candidates], kind="stable")].tolist():
        if all(abs(column - other) >= _APART for other in chosen):
            chosen.append(column)
    return sorted(chosen)


def _fit(strips: Strips, column: int) -> float | None:
    """Column, at the mean height, of a line through each strip's steepest fall near `column`."""
    low, high = max(1, column - _REACH - 1), min(strips.grey.shape[1] - 1, column + _REACH + 2)
    slope = strips.grey[:, low - 1 : high - 1] - strips.grey[:, low + 1 : high + 1]
    rows = np.flatnonzero(~np.isnan(slope).any(axis=1))
    if len(rows) < _FEWEST_STRIPS or slope.shape[1] < 3:
        return None
    slope = slope[rows]
    steepest = np.clip(slope.argmax(axis=1), 1, slope.shape[1] - 2)
    index = np.arange(len(rows))
    a, b, c = slope[index, steepest - 1], slope[index, steepest], slope[index, steepest + 1]
    bend = a - 2 * b + c
    offset = np.where(bend < -1e-9, 0.5 * (a - c) / np.minimum(bend, -1e-9), 0.0)
    return _robust_line(strips.z[rows] - strips.z.mean(), low + steepest + np.clip(offset, -0.5, 0.5))


def _robust_line(z: FloatArray, columns: FloatArray) -> float:
    """Value at z = 0 of a line fitted with Tukey's weights: title and bands pull single strips astray."""
    weights = np.ones(len(z))
    level, slope = float(np.median(columns)), 0.0
    for _ in range(6):
        residuals = columns - level - slope * z
        scale = max(0.3, 1.48 * float(np.median(np.abs(residuals))))
        weights = np.maximum(1.0 - (residuals / (4.0 * scale)) ** 2, 0.0) ** 2
        weights /= weights.sum()
        mean_z, mean_c = float(weights @ z), float(weights @ columns)
        spread = float(weights @ (z - mean_z) ** 2)
        slope = float(weights @ ((z - mean_z) * (columns - mean_c))) / max(spread, 1e-6)
        level = mean_c - slope * mean_z
    return level
