"""The edges of a bright rectangle in a plane, to a fraction of a pixel."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.numerics.arrays import BoolArray, FloatArray
from handcart.robotics.perception.blocks.edge_step import SAMPLE_POSITIONS_PX, fit_steps
from handcart.robotics.perception.blocks.plane_view import PlaneView
from handcart.robotics.perception.blocks.rectangle import (
    AXIS,
    OTHER,
    OUTWARD_NORMALS,
    Rectangle,
    across,
    shares,
)
from handcart.robotics.perception.blocks.rough_rectangle import rough_rectangle

_ROWS, _SEGMENTS = 48, 8  # profiles across an edge; they are averaged in segments
_LEAST_DROP = 6.0  # grey levels
_SIZE_WITHIN = 0.002
_ROUNDS, _SETTLED, _SETTLED_TURN = 5, 0.0002, 0.004  # fits, and what the last may still change [m, rad]
_LEAST_LIT, _LEAST_IN_ALL = 2, 16  # of an edge's segments, and of all
_LEAST_STRAIGHT = 0.6  # share of them
_ODD = 0.0005  # off the edge's usual profile: something else is seen there [m]
_STRAIGHT, _OUTLIER = 0.00008, 0.00016  # rms of all segments about the rectangle, and of a single one [m]
_GRAZING = 0.018  # beyond an edge by so much of its height the camera sees a strip of a pixel or so
_BEYOND = 0.0005, 0.0025  # from a corner, where an edge may continue [m]
_INSIDE = 0.001  # of the edges the face is of one shade [m]
_UNIFORM = 0.05  # rms of the face's greys about even light, as a share of its grey
_STRIPES = 0.012  # the same of what a side's face at its rim would change


class _Edges(NamedTuple):
    """Points on the four edges, in the order +x, +y, -x, -y, k segments of each."""

    along: FloatArray
    """Positions (4, k) along each edge from its middle, in [m]."""
    out: FloatArray
    """Distances (4, k) outwards from each edge as it was assumed, in [m]."""
    lit: BoolArray
    """Mask (4, k) of the segments that are visible and agree with the others of their edge."""
    seen: BoolArray
    """Mask (4,) of the edges that were found."""
    sure: BoolArray
    """Mask (4,) of the found edges that cannot be confused with an edge of the foot."""


def fit_rectangle(view: PlaneView, size: tuple[float, float], guess: Pose2) -> Pose2 | None:
    """Return plane_T_centre of a bright rectangle near a guess; None if it is not found.

    The edges are lines in the plane, fitted to points that are measured to a fraction of a pixel. Lens and
    perspective are corrected in the positions at which the image is sampled; the image is not warped. None if
    fewer than three edges are found, if they differ from a rectangle of the given size by more than 2 mm, or
    if the area inside isn't of one shade.

    Args:
        view: image of the plane.
        size: length (along x) and width of the rectangle, in [m].
        guess: plane_T_centre, at most 2 mm and 0.04 rad off.
    """
    rough = rough_rectangle(view, size, guess, _SIZE_WITHIN, _LEAST_DROP)
    if rough is None:
        return None
    wanted = np.array(size) / 2
    fine = _settled(view, wanted, _by_far_edges(view, wanted, rough))
    if fine is None or not _one_shade(view, fine) or (not fine.seen.all() and _goes_on(view, fine)):
        return None
    return fine.pose


def _by_far_edges(view: PlaneView, wanted: FloatArray, rough: Rectangle) -> Rectangle:
    """Return the rectangle of the wanted size at its far edges.

    Below a near edge a side face is visible, whose foot may have been confused with the edge.
    """
    eye = view.eye(rough.pose)[:2]
    towards = np.where(np.abs(eye) > rough.half, np.sign(eye), 0.0)
    x, y = (towards * (wanted - rough.half)).tolist()
    return Rectangle(rough.pose.compose(Pose2(x, y, 0.0)), wanted, rough.seen)


def _settled(view: PlaneView, wanted: FloatArray, last: Rectangle) -> Rectangle | None:
    """Repeat the fit from its last result until that hardly changes; None if a fit fails."""
    for _ in range(_ROUNDS):
        edges = _edges(view, last)
        fine = None if edges is None else _enclosed(last, wanted, edges)
        if fine is None:
            return None
        if fine.pose.distance(last.pose) < _SETTLED and fine.pose.turn(last.pose) < _SETTLED_TURN:
            return fine
        last = fine
    return None


def _edges(view: PlaneView, rectangle: Rectangle) -> _Edges | None:
    """Fit a step to each edge's median profile, and that step to the profiles of all its segments."""
    share, scale = shares(_ROWS), _m_per_px(view, rectangle)
    ends = across(rectangle.half, share, scale * SAMPLE_POSITIONS_PX[0], scale * SAMPLE_POSITIONS_PX[-1])
    greys = view.profiles(rectangle.pose, *ends, len(SAMPLE_POSITIONS_PX))
    if greys is None:
        return None
    eye = view.eye(rectangle.pose)
    beyond = (OUTWARD_NORMALS @ eye[:2] - rectangle.half[AXIS]) / eye[2]
    segments = greys.reshape(4, _SEGMENTS, -1, len(SAMPLE_POSITIONS_PX)).mean(axis=2)
    lit = _lit(segments)
    steps = fit_steps(_usual(segments, lit), beyond < 0.0, _LEAST_DROP)
    off = _displaced(segments, steps.model) * scale[:, None]
    lit &= np.abs(off) < _ODD
    seen = (steps.drop > 0.0) & (lit.sum(axis=1) >= _LEAST_LIT)
    grazing = (beyond >= 0.0) & (beyond < _GRAZING)
    along = rectangle.half[OTHER, None] * share.reshape(_SEGMENTS, -1).mean(axis=1)
    out = (steps.at * scale)[:, None] + off
    return _Edges(along, out, lit, seen, seen & ~(grazing & np.roll(seen, 2)))


def _m_per_px(view: PlaneView, rectangle: Rectangle) -> FloatArray:
    """Return the metres per pixel (4,) across each edge, in its middle."""
    step = np.full(4, 0.0005)
    ends = view.pixels(rectangle.pose, np.stack(across(rectangle.half, np.zeros(1), -step, step)))
    return np.asarray(2 * step / np.linalg.norm(ends[1] - ends[0], axis=-1)[:, 0])


def _lit(segments: FloatArray) -> BoolArray:
    """Return True for segments (4, k, m) that are darker further out: an edge may border partly on a bright
    thing.
    """
    smooth = segments[..., 2:] + segments[..., 1:-1] + segments[..., :-2]
    return np.asarray(smooth[..., :3].mean(axis=-1) - smooth.min(axis=-1) >= 3 * _LEAST_DROP)


def _usual(segments: FloatArray, lit: BoolArray) -> FloatArray:
    """Return the median (4, m) of each edge's lit segments, because the background may change along an
    edge.
    """
    if lit.all():
        return np.asarray(np.median(segments, axis=1))
    chosen = [
        segment[there] if there.any() else segment for segment, there in zip(segments, lit, strict=True)
    ]
    return np.array([np.median(item, axis=0) for item in chosen])


def _displaced(segments: FloatArray, model: FloatArray) -> FloatArray:
    """Return how much further out than the model (4, m) each segment (4, k, m) is, in [px], to first
    order.
    """
    slope = (model[:, 2:] - model[:, :-2]) / (SAMPLE_POSITIONS_PX[2] - SAMPLE_POSITIONS_PX[0])
    slope -= slope.mean(axis=1, keepdims=True)
    differs = np.matmul((segments - model[:, None])[..., 1:-1], slope[..., None])[..., 0]
    return np.asarray(-differs / np.maximum((slope**2).sum(axis=1), 1e-9)[:, None])


def _enclosed(last: Rectangle, wanted: FloatArray, edges: _Edges) -> Rectangle | None:
    """Fit centre, turn and both sizes by least squares.

    If only one of two opposite edges is sure, their distance is the wanted one, plus the excess of the
    other two: bright things look larger than they are, on all sides.
    """
    if edges.seen.sum() < 3 or edges.lit[edges.seen].sum() < _LEAST_IN_ALL:
        return None
    rows = np.zeros((*edges.out.shape, 5))
    rows[..., :2] = OUTWARD_NORMALS[:, None]
    rows[..., 2] = -edges.along
    rows[[0, 2], :, 3] = rows[[1, 3], :, 4] = 1.0
    fixed = ~(edges.sure[:2] & edges.sure[2:])
    growth = np.array([[1.0, 0.0], [0.0, 1.0]]) if fixed.all() else np.array([[1.0, -1.0], [-1.0, 1.0]])
    bounds = 1e3 * np.column_stack([np.zeros((2, 3)), growth])[fixed]
    sizes = 1e3 * (growth @ (wanted - last.half))[fixed]
    used = edges.lit & edges.sure[:, None]
    least = _LEAST_STRAIGHT * used.sum(axis=1)
    for _ in range(3):  # each time without what was far off
        A, b = np.vstack([rows[used], bounds]), np.append(edges.out[used], sizes)
        found = np.linalg.solve(A.T @ A, A.T @ b)
        rest = np.abs(edges.out - rows @ found)
        used &= rest < _OUTLIER
        if (used.sum(axis=1) < least).any():
            return None
    x, y, turn, *grown = found.tolist()
    half = last.half + grown
    off = [2 * np.abs(half - wanted).max()]
    off += [np.median(rest[i, edges.lit[i]]) for i in np.flatnonzero(edges.seen & ~edges.sure)]
    if max(off) > _SIZE_WITHIN or np.sqrt(np.mean(rest[used] ** 2)) > _STRAIGHT:
        return None
    return Rectangle(last.pose.compose(Pose2(x, y, turn)), half, edges.seen)


def _one_shade(view: PlaneView, rectangle: Rectangle) -> bool:
    """Return True if the inside differs from evenly changing light by little more than noise."""
    count = 16
    x, y = rectangle.half - _INSIDE
    rows = np.linspace(-y, y, count)
    first, last = (np.column_stack([np.full(count, end), rows]) for end in (-x, x))
    greys = view.profiles(rectangle.pose, first, last, count)
    if greys is None:
        return False
    share = np.linspace(-1.0, 1.0, count)
    level = float(greys.mean())
    # On a grid, level and slopes are independent.
    tilt, lean = (greys.mean(axis=axis) @ share / (share @ share) for axis in (0, 1))
    rest = greys - level - tilt * share - lean * share[:, None]
    stripes = max(float(np.sqrt(np.mean(rest.mean(axis=axis) ** 2))) for axis in (0, 1))
    return bool(np.sqrt(np.mean(rest**2)) < _UNIFORM * level and stripes < _STRIPES * level)


def _goes_on(view: PlaneView, rectangle: Rectangle) -> bool:
    """Return True if both edges next to the missing one continue beyond it: then the thing is larger than
    wanted.
    """
    missing = int(np.flatnonzero(~rectangle.seen)[0])
    sides = [(missing - 1) % 4, (missing + 1) % 4]
    out = (4.0 * _m_per_px(view, rectangle))[sides, None, None] * OUTWARD_NORMALS[sides][:, None]
    edges = rectangle.half[AXIS[sides], None, None] * OUTWARD_NORMALS[sides][:, None]
    before, beyond = (
        edges
        + (rectangle.half[AXIS[missing]] + np.linspace(*stretch, _ROWS))[:, None] * OUTWARD_NORMALS[missing]
        for stretch in ((-_BEYOND[1], -_BEYOND[0]), _BEYOND)
    )
    both = np.stack([before, beyond])
    greys = view.profiles(rectangle.pose, both - out, both + out, 9)
    if greys is None:
        return True
    mean = greys.mean(axis=2)
    inside, outside = (mean[..., part].mean(axis=-1) for part in (slice(3), slice(-3, None)))
    drop = inside - outside
    return bool((drop[1] > 0.5 * drop[0]).all())
