"""The four edges of a bright rectangle in a plane, to a fraction of a pixel."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from robotics.geometry.pose2 import Pose2
from robotics.perception.camera_model import Floats
from robotics.perception.edge_step import PLACES, fit_steps
from robotics.perception.plane_view import PlaneView

_OUT: Floats = np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]])
_ALONG: Floats = np.array([[0.0, 1.0], [-1.0, 0.0], [0.0, -1.0], [1.0, 0.0]])
_AXIS, _OTHER = np.array([0, 1, 0, 1]), np.array([1, 0, 1, 0])
_ENDS = 0.08  # of an edge at each end is left out: the blurred corners
_ROUGH_ROWS, _ROWS, _SEGMENTS = 16, 48, 8  # profiles across an edge; they are averaged in segments
_REACH, _COUNT = 0.0036, 25  # of the rough profiles, on each side [m]
_SPACING = 2 * _REACH / (_COUNT - 1)
_SLOPES: Floats = np.arange(-0.045, 0.0451, 0.0075)
_LEAST_DROP = 6.0  # grey levels
_SIZE_WITHIN = 0.002
_STRAIGHT, _OUTLIER = 0.00012, 0.0004  # rms of all segments about the rectangle, and of a single one [m]
_LEAST_LIT = 2  # of an edge's segments
_LEAST_FOUND = 0.6  # of those
_GRAZING = 0.018  # beyond the edge by so much of its height the camera sees a strip of a pixel or so
_UNIFORM = 0.05  # rms of the face's greys about even light, as a share of its grey

Bools = NDArray[np.bool_]


class _Rectangle(NamedTuple):
    pose: Pose2
    half: Floats
    """(2,) half of length and width, in [m]."""
    seen: Bools
    """(4,) whether the edges at +x, +y, -x, -y were found."""


def fit_rectangle(view: PlaneView, size: tuple[float, float], guess: Pose2) -> Pose2 | None:
    """The bright rectangle of `size` [m] near a guess in the plane, at most 2 mm and 0.04 rad off.

    The edges are lines in the plane, through points to a fraction of a pixel: lens and perspective are undone
    by where the image is sampled, not by warping it. None if fewer than three edges are there, if they aren't
    those of a rectangle of that size within 2 mm, or if what they enclose isn't of one shade.
    """
    wanted = np.array(size) / 2
    rough = _rough(view, wanted, guess)
    if rough is None or not _one_shade(view, rough):
        return None
    fine = _fine(view, wanted, rough)
    if fine is not None:
        fine = _fine(view, wanted, fine)
    if fine is None or (not fine.seen.all() and _goes_on(view, fine)):
        return None
    return fine.pose


def _rough(view: PlaneView, half: Floats, guess: Pose2) -> _Rectangle | None:
    """To about a pixel: the innermost step down across each edge, all edges turned alike."""
    share = _shares(_ROUGH_ROWS)
    reach = np.full(4, _REACH)
    greys = view.profiles(guess, *_across(half, share, -reach, reach), _COUNT)
    if greys is None:
        return None
    drops = _drops(_sheared(greys, share, half))  # (4, slopes, n)
    # What is seen beneath an edge is parallel to it: the steepest steps tell the slope, whichever they are.
    slope = int(np.sqrt(np.maximum(drops.max(axis=-1), 0.0)).sum(axis=0).argmax())
    chosen = drops[:, slope]
    inner = chosen[:, 1:-1]
    peak = (inner >= _LEAST_DROP) & (inner >= chosen[:, :-2]) & (inner > chosen[:, 2:])
    seen = peak.any(axis=1)
    # Counted from the middle of the profile.
    out = (peak.argmax(axis=1) + 1 - (drops.shape[-1] - 1) / 2) * _SPACING
    return _moved(guess, half, seen, np.where(seen, out, 0.0), float(_SLOPES[slope]))


def _shares(count: int) -> Floats:
    """Places along an edge, from -1 to 1."""
    return np.linspace(-1.0, 1.0, count) * (1.0 - 2 * _ENDS)


def _across(half: Floats, share: Floats, inner: Floats, outer: Floats) -> tuple[Floats, Floats]:
    """Ends (4, n, 2) of profiles `share` (n,) along the edges, from `inner` to `outer` (4,) [m] out of them."""
    along = (half[_OTHER, None] * share)[..., None] * _ALONG[:, None]
    first, last = (((half[_AXIS] + each)[:, None] * _OUT)[:, None] + along for each in (inner, outer))
    return first, last


def _sheared(greys: Floats, share: Floats, half: Floats) -> Floats:
    """Mean profiles (4, slopes, m) along lines of all slopes."""
    shift = -half[_OTHER, None, None] * share * _SLOPES[:, None] / _SPACING  # (4, slopes, rows)
    place = np.clip(np.arange(_COUNT) + shift[..., None], 0.0, _COUNT - 1.001)
    low = place.astype(np.intp)
    part = place - low
    flat = low + (np.arange(4)[:, None, None, None] * len(share) + np.arange(len(share))[:, None]) * _COUNT
    before, after = greys.ravel()[flat], greys.ravel()[flat + 1]
    return np.asarray((before + (after - before) * part).mean(axis=2))


def _drops(profiles: Floats) -> Floats:
    """By how much two samples are brighter than two others three further out, (..., m - 4)."""
    pairs = profiles[..., :-1] + profiles[..., 1:]
    return np.asarray(pairs[..., :-3] - pairs[..., 3:]) / 2


def _moved(guess: Pose2, half: Floats, seen: Bools, out: Floats, turn: float) -> _Rectangle | None:
    """The rectangle of halves `half` at a guess, turned, with its edges `out` (4,) [m] further out."""
    if seen.sum() < 3:
        return None
    out = np.where(seen, out, -np.roll(out, 2))
    grown = (out[:2] + out[2:]) / 2
    if np.abs(grown).max() > _SIZE_WITHIN / 2:
        return None
    x, y = ((out[:2] - out[2:]) / 2).tolist()
    return _Rectangle(guess.compose(Pose2(0.0, 0.0, turn)).compose(Pose2(x, y, 0.0)), half + grown, seen)


def _fine(view: PlaneView, wanted: Floats, rough: _Rectangle) -> _Rectangle | None:
    """To a fraction of a pixel: steps are fitted to each edge's mean profile, then that to its segments."""
    share = _shares(_ROWS)
    scale = _m_per_px(view, rough)
    ends = _across(rough.half, share, scale * PLACES[0], scale * PLACES[-1])
    greys = view.profiles(rough.pose, *ends, len(PLACES))
    if greys is None:
        return None
    eye = view.eye(rough.pose)
    beyond = (_OUT @ eye[:2] - rough.half[_AXIS]) / eye[2]
    segments = greys.reshape(4, _SEGMENTS, -1, len(PLACES)).mean(axis=2)
    lit = _lit(segments)
    steps = fit_steps(_usual(segments, lit), beyond < 0.0, _LEAST_DROP)
    seen = (steps.drop > 0.0) & (lit.sum(axis=1) >= _LEAST_LIT)
    slope = np.gradient(steps.model, PLACES, axis=1)
    slope -= slope.mean(axis=1, keepdims=True)
    # To first order a displaced profile differs by its slope.
    differs = segments - steps.model[:, None]
    off = -np.matmul(differs, slope[..., None])[..., 0] / np.maximum((slope**2).sum(axis=1), 1e-9)[:, None]
    grazing = (beyond >= 0.0) & (beyond < _GRAZING)
    used = seen & ~(grazing & np.roll(seen, 2))
    along = half_along(rough.half, share)
    return _least_squares(rough, wanted, seen, used, along, (steps.at[:, None] + off) * scale[:, None], lit)


def _lit(segments: Floats) -> Bools:
    """Which segments (4, k) are darker somewhere further out: an edge may border partly on what is as bright."""
    smooth = segments[..., 2:] + segments[..., 1:-1] + segments[..., :-2]
    return np.asarray((smooth[..., :3].mean(axis=-1) - smooth.min(axis=-1)) / 3 >= _LEAST_DROP)


def _usual(segments: Floats, lit: Bools) -> Floats:
    """(4, 21) the median of each edge's segments that are lit: what lies beneath may change along an edge."""
    return np.array([np.median(each[there if there.any() else ...], axis=0) for each, there in zip(segments, lit, strict=True)])


def half_along(half: Floats, share: Floats) -> Floats:
    return np.asarray(half[_OTHER, None] * share.reshape(_SEGMENTS, -1).mean(axis=1))


def _m_per_px(view: PlaneView, rectangle: _Rectangle) -> Floats:
    """(4,) across each edge, in its middle."""
    step = np.full(4, 0.0005)
    first, last = view.pixels(
        rectangle.pose, np.stack(_across(rectangle.half, np.zeros(1), -step, step))
    )
    return np.asarray(2 * step / np.linalg.norm(last - first, axis=-1)[:, 0])


def _least_squares(
    rough: _Rectangle, wanted: Floats, seen: Bools, used: Bools, along: Floats, out: Floats, lit: Bools
) -> _Rectangle | None:
    """Middle, turn and both sizes from points on the edges: `along` and `out` (4, k) in [m].

    An axis with only one edge to use has the size that is wanted.
    """
    if seen.sum() < 3:
        return None
    rows = np.zeros((4, _SEGMENTS, 5))
    rows[..., :2] = _OUT[:, None]
    rows[..., 2] = -along
    rows[[0, 2], :, 3] = rows[[1, 3], :, 4] = 1.0
    fixed = ~(used[:2] & used[2:])
    bounds = np.eye(5)[3:][fixed]
    at = (wanted - rough.half)[fixed]
    points = lit & used[:, None]
    least = _LEAST_FOUND * points.sum(axis=1)
    for _ in range(2):
        A, b = np.vstack([rows[points], bounds]), np.append(out[points], at)
        found = np.linalg.lstsq(A, b, rcond=None)[0]
        rest = np.abs(out - rows @ found)
        points &= rest < _OUTLIER
    if (points.sum(axis=1) < least).any() or np.sqrt((rest[points] ** 2).mean()) > _STRAIGHT:
        return None
    x, y, turn, *grown = found.tolist()
    half = rough.half + grown
    if np.abs(half - wanted).max() > _SIZE_WITHIN / 2:
        return None
    return _Rectangle(rough.pose.compose(Pose2(x, y, turn)), half, seen)


def _one_shade(view: PlaneView, rectangle: _Rectangle) -> bool:
    """Whether the inside differs from evenly changing light by little more than noise."""
    x, y = 0.8 * rectangle.half
    rows = np.linspace(-y, y, 16)
    first, last = (np.column_stack([np.full(16, end), rows]) for end in (-x, x))
    greys = view.profiles(rectangle.pose, first, last, 16)
    if greys is None:
        return False
    share = np.linspace(-1.0, 1.0, 16)
    level = greys.mean()
    # Orthogonal on a grid: each slope by itself.
    tilt, lean = (each @ share / (share @ share) for each in (greys.mean(axis=0), greys.mean(axis=1)))
    rest = greys - level - tilt * share - lean * share[:, None]
    return bool(np.sqrt(np.mean(rest**2)) < _UNIFORM * level)


def _goes_on(view: PlaneView, rectangle: _Rectangle) -> bool:
    """Whether both edges next to the missing one go on beyond it: then the thing is larger than it should be."""
    missing = int(np.flatnonzero(~rectangle.seen)[0])
    return False
