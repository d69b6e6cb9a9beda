"""Slots by geometry: parts that differ between two neighbouring views lie behind the shelf's front."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations, pairwise
from typing import NamedTuple

import numpy as np

from handcart.robotics.numerics.arrays import FloatArray
from handcart.robotics.perception.books.spines import SpineView

MIN_SLOT_M = 0.005  # [m]
_LEAST_BASE, _MOST_BASE = 0.045, 0.16  # [m] between two cameras: with less, deep edges hardly shift
_STEP = 0.0003  # [m] between the columns that are compared
_RIM = 0.0015  # [m] beside an edge that isn't compared
_SAME_EDGE = 0.0012  # [m] between two views, of an edge that lies in the front
_PROUD, _AWAY = 0.004, 0.285  # [m] of spines before or behind the front; of the camera
_OFF = 0.0006  # [m] that two views may be aligned wrong
_SEEN = 0.6  # of a piece, at least
_NOISE = 1.2  # grey levels by which strips of the same thing differ
_LEAST, _SHARE = 2.5, 0.5  # of a deep piece: grey levels, and share of what it shows, by which views differ


class Gap(NamedTuple):
    """Free slot between two books, or between a book and a side panel of the shelf.

    `left` > `right` are y of its edges in the shelf frame, in [m].
    """

    left: float
    right: float

    @property
    def width(self) -> float:
        """Distance between the gap's edges, in [m]."""
        return self.left - self.right


class Alike(NamedTuple):
    """Result of comparing two views of a piece of the shelf's front.

    `apart` is the difference of the views in grey levels at the best match. `shows` is the contrast of the
    piece, as the mean deviation of its grey levels from their median.
    """

    apart: float
    shows: float

    @property
    def deep(self) -> bool:
        """True if the surface seen in this piece of the shelf's front can't be in the front's plane, but is
        behind it.
        """
        return self.apart > _NOISE + _LEAST and self.apart - _NOISE > _SHARE * self.shows


def find_slots(
    views: Sequence[SpineView], offsets: Sequence[float], interval: Gap, solid: Sequence[tuple[float, float]]
) -> tuple[Gap, ...]:
    """Return the free slots in an interval of the shelf's front, from left to right.

    The two views taken from the places nearest to the interval are compared, by parallax. An edge at the same
    position in both views is the end of a surface in the front plane. The piece between two such edges is a
    free slot if the views differ however they are shifted against each other. A piece that looks the same in
    both views is not free, because it is a spine or can't be distinguished from a spine.

    Args:
        views: views taken in front of the shelf.
        offsets: number that is added to y of each view, in [m].
        interval: interval between two spines that were recognized.
        solid: left and right edge y of each recognized spine, in [m]; the brightness of the views is matched
            there.
    """
    pair = _best_pair(views, offsets, interval)
    if pair is None:
        return ()
    a, b = pair
    cuts = [interval.left, *_shared_edges(a, b, interval), interval.right]
    pieces = list(pairwise(cuts))
    compared = [compare(a, b, left, right, solid) for left, right in pieces]
    deep = [alike is not None and alike.deep for alike in compared]
    slots: list[Gap] = []
    for i, (left, right) in enumerate(pieces):
        # No book is as thin as a piece that cannot be compared: edges can also lie within a slot.
        thin = left - right < MIN_SLOT_M and any(deep[max(0, i - 1) : i + 2])
        if not deep[i] and not thin:
            continue
        if slots and slots[-1].right == left:
            slots[-1] = slots[-1]._replace(right=right)
        else:
            slots.append(Gap(left, right))
    return tuple(slot for slot in slots if slot.width >= MIN_SLOT_M)


class OffsetView(NamedTuple):
    """View of the shelf, with an offset in [m] that is added to lateral positions y in this view so that they
    agree with other views.
    """

    view: SpineView
    offset: float

    @property
    def eye(self) -> float:
        """y of the camera in the shelf frame, in [m]."""
        return self.view.eye + self.offset

    def at(self, y: FloatArray) -> FloatArray:
        """Return the grey levels (n, m), 0 to 255, of the view's n strips at lateral positions; NaN if not
        visible.

        Args:
            y: (m,) lateral positions in the shelf frame, in [m].
        """
        return self.view.strips.at(y - self.offset)

    def shows(self, interval: Gap) -> bool:
        """Return True if the camera saw most of a free slot between books, both ends included."""
        ends = np.array([interval.left + 0.001, interval.right - 0.001])
        if ends[0] > self.view.left + self.offset or ends[1] < self.view.right + self.offset:
            return False
        return bool(np.mean(~np.isnan(self.at(_columns(interval.left, interval.right)))) > _SEEN)


def _best_pair(
    views: Sequence[SpineView], offsets: Sequence[float], interval: Gap
) -> tuple[OffsetView, OffsetView] | None:
    """Return the two views of an interval whose cameras are nearest to its middle, neither at the same place
    nor far apart.
    """
    middle = (interval.left + interval.right) / 2
    placed = [OffsetView(view, offset) for view, offset in zip(views, offsets, strict=True)]
    seeing = [offset_view for offset_view in placed if offset_view.shows(interval)]
    pairs = [p for p in combinations(seeing, 2) if _LEAST_BASE <= abs(p[0].eye - p[1].eye) <= _MOST_BASE]
    return min(pairs, key=lambda p: sum((item.eye - middle) ** 2 for item in p), default=None)


def _shared_edges(a: OffsetView, b: OffsetView, interval: Gap) -> list[float]:
    """y of edges that both views have in one place within an interval, from left to right."""
    edges: list[float] = []
    for mine in sorted((y + a.offset for y in a.view.sides), reverse=True):
        other = min((y + b.offset for y in b.view.sides), key=lambda y: abs(y - mine), default=None)
        if other is None or abs(other - mine) > _SAME_EDGE:
            continue
        y = (mine + other) / 2
        if interval.right + _RIM < y < interval.left - _RIM and (not edges or edges[-1] - y > _RIM):
            edges.append(y)
    return edges


def compare(
    a: OffsetView, b: OffsetView, left: float, right: float, solid: Sequence[tuple[float, float]]
) -> Alike | None:
    """Return how well two views of a piece of the shelf's front match, at the best lateral shift.

    A piece whose views match at no shift is behind the front plane (`Alike.deep`). None if the piece is
    narrower than about 4 mm, or less than 60 % of it is visible in both views.

    Args:
        a: one view.
        b: another view.
        left: left end y of the piece in the shelf frame, in [m].
        right: right end y of the piece, in [m].
        solid: left and right edge y of each recognized spine in the shelf frame, in [m]; the brightness of
            the views is matched there.
    """
    if left - right < 2 * _RIM + 4 * _STEP:
        return None
    y = _columns(left - _RIM, right + _RIM)
    mine, level = a.at(y), _brightness(a, b, y, solid)
    most = _PROUD / _AWAY * abs(a.eye - b.eye) + _OFF
    apart = []
    for shift in np.arange(-most, most + _STEP / 2, _STEP):
        difference = np.abs(mine - level * b.at(y + shift))
        if np.mean(~np.isnan(difference)) < _SEEN:
            continue
        apart.append(float(np.nanmean(difference)))
    if not apart:
        return None
    both = (mine, level * b.at(y))
    shows = float(np.mean([np.nanmean(np.abs(grey - np.nanmedian(grey))) for grey in both]))
    return Alike(min(apart), shows)


def _columns(left: float, right: float) -> FloatArray:
    return np.arange(left, right, -_STEP)


def _brightness(
    a: OffsetView, b: OffsetView, y: FloatArray, solid: Sequence[tuple[float, float]]
) -> FloatArray:
    """Return the brightness of `a` as a multiple of that of `b` at each of `y` (m,), in [m].

    It is a line through the ratios at their common spines, 1 without any.
    """
    places, ratios = [], []
    for left, right in solid:
        columns = _columns(left - _RIM, right + _RIM)
        if len(columns) < 4:
            continue
        ratio = a.at(columns) / np.maximum(b.at(columns), 1.0)
        if np.mean(~np.isnan(ratio)) > _SEEN:
            places.append((left + right) / 2)
            ratios.append(float(np.nanmedian(ratio)))
    if not places:
        return np.ones(len(y))
    if len(places) < 3:
        return np.full(len(y), float(np.mean(ratios)))
    line = np.polyfit(places, ratios, 1)
    return np.asarray(np.clip(np.polyval(line, y), 0.5, 2.0))
