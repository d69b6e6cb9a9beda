"""Edges of a bright rectangle, to a pixel."""

from __future__ import annotations

import numpy as np

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.numerics.arrays import BoolArray, FloatArray
from handcart.robotics.perception.blocks.plane_view import PlaneView
from handcart.robotics.perception.blocks.rectangle import OTHER, Rectangle, across, shares

_ROWS = 16  # profiles across an edge
_REACH, _COUNT = 0.0036, 25  # on each side of an edge [m], and samples
_SPACING = 2 * _REACH / (_COUNT - 1)
_SLOPES: FloatArray = np.arange(-0.045, 0.0451, 0.01)


def rough_rectangle(
    view: PlaneView, size: tuple[float, float], guess: Pose2, within: float, least: float
) -> Rectangle | None:
    """Return a rough estimate of a rectangle near a guess; the guess may be off by at most 2 mm and 0.04 rad.

    On each side of the rectangle the innermost decrease of grey by at least `least` levels is taken; all
    sides are assumed to be turned by the same angle. None if such a decrease is found on fewer than three
    sides, or if opposite sides are not `size` apart.

    Args:
        view: image of the plane.
        size: length (along x) and width of the rectangle, in [m].
        guess: guessed plane_T_centre of the rectangle.
        within: largest difference of a side from its size, in [m].
        least: least decrease of grey at an edge, in grey levels.
    """
    half, share = np.array(size) / 2, shares(_ROWS)
    reach = np.full(4, _REACH)
    greys = view.profiles(guess, *across(half, share, -reach, reach), _COUNT)
    if greys is None:
        return None
    drops = _drops(_sheared(greys, share, half))  # (4, slopes, n)
    # Marks below an edge are parallel to it: the steepest steps give the slope in any case.
    sharp = np.sqrt(np.maximum(drops.max(axis=-1), 0.0)).sum(axis=0)
    chosen = drops[:, int(sharp.argmax())]
    inner = chosen[:, 1:-1]
    peak = (inner >= least) & (inner >= chosen[:, :-2]) & (inner > chosen[:, 2:])
    seen: BoolArray = np.asarray(peak.any(axis=1))
    # Counted from the middle of the profile.
    out = (peak.argmax(axis=1) + 1 - (chosen.shape[1] - 1) / 2) * _SPACING
    return _moved(guess, half, seen, out, _top(sharp), within)


def _sheared(greys: FloatArray, share: FloatArray, half: FloatArray) -> FloatArray:
    """Mean profiles (4, slopes, m) along lines of all slopes."""
    shift = -half[OTHER, None, None] * share * _SLOPES[:, None] / _SPACING  # (4, slopes, rows)
    place = np.clip(np.arange(_COUNT) + shift[..., None], 0.0, _COUNT - 1.001)
    low = place.astype(np.intp)
    part = place - low
    flat = low + np.arange(4 * len(share)).reshape(4, 1, -1, 1) * _COUNT
    before, after = greys.ravel()[flat], greys.ravel()[flat + 1]
    return np.asarray((before + (after - before) * part).mean(axis=2))


def _drops(profiles: FloatArray) -> FloatArray:
    """Return how much brighter two samples are than two others three further out, (..., m - 4)."""
    pairs = profiles[..., :-1] + profiles[..., 1:]
    return np.asarray(pairs[..., :-3] - pairs[..., 3:]) / 2


def _top(sharp: FloatArray) -> float:
    """Return the slope of the sharpest edges, by a parabola."""
    best = min(max(int(sharp.argmax()), 1), len(sharp) - 2)
    before, top, after = sharp[best - 1 : best + 2].tolist()
    share = (after - before) / max(1e-9, 4 * top - 2 * before - 2 * after)
    return float(_SLOPES[best] + min(max(share, -1.0), 1.0) * (_SLOPES[1] - _SLOPES[0]))


def _moved(
    guess: Pose2, half: FloatArray, seen: BoolArray, out: FloatArray, turn: float, within: float
) -> Rectangle | None:
    """Return the rectangle at a guess, turned, with its edges `out` (4,) [m] further out."""
    if seen.sum() < 3:
        return None
    out = np.where(seen, out, -np.roll(out, 2))
    grown = (out[:2] + out[2:]) / 2
    if np.abs(grown).max() > within / 2:
        return None
    x, y = ((out[:2] - out[2:]) / 2).tolist()
    return Rectangle(guess.compose(Pose2(0.0, 0.0, turn)).compose(Pose2(x, y, 0.0)), half + grown, seen)
