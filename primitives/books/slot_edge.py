"""The sides of a slot, seen past a held book."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from handcart.robotics.perception.books.flat_view import flat_view
from handcart.robotics.perception.books.spine_edges import (
    Strips,
    all_sides,
    falling_edges,
    strips_of,
    upright,
)

from .hand_view import HandView

M_PER_PX = 0.0003
STRIP_HEIGHTS_M = (0.045, 0.160)  # above the board: heights that are visible from where a book goes in
SPINE, DARK = (
    (0.010, 0.002),
    (0.001, 0.005),
)  # [m] left and right of the side: where spine and slot are compared
LOW_HEIGHTS = (0.012, 0.150)  # [m]: the same from the height at which labels are read
SLOT_PLAY_RANGE_M = (0.0, 0.015)  # by which a slot may be wider than its book, as measured
SIDE_SHIFT_TOLERANCE_M = 0.001  # that sides of books move unlike each other
MIN_VISIBLE_SHARE = 0.7  # of where a side may be, at least
SLOT_BRIGHTNESS_RATIO = 0.65  # a slot's brightness, against the spine's


def seen_past(view: HandView) -> Strips:
    """Return strips of averaged picture rows that show the books on the shelf next to a held book, at its
    height.
    """
    return _strips(view, STRIP_HEIGHTS_M)


def slot_edge(strips: Strips, expected: float, within: float, surely: float) -> float | None:
    """Return y of a slot's left side in the shelf frame, in [m]; None if no such side is seen.

    In most shelves a slot is darker than the book to its left. An edge (change of brightness) that is darker
    on the slot's side therefore takes precedence over others.

    Args:
        strips: averaged rows of the picture, where it shows the shelf next to the held book.
        expected: y of the side in an earlier view, in [m].
        within: maximum distance of a darker edge from `expected`, in [m].
        surely: maximum distance of another edge from `expected`, in [m].
    """
    darker: list[float] = []
    others: list[float] = []
    for edge in falling_edges(strips):
        spine = strips.brightness(edge.y + SPINE[0], edge.y + SPINE[1], STRIP_HEIGHTS_M[0])
        slot = strips.brightness(edge.y - DARK[0], edge.y - DARK[1], STRIP_HEIGHTS_M[0])
        dark = spine is not None and slot is not None and slot < SLOT_BRIGHTNESS_RATIO * spine
        if abs(edge.y - expected) < (within if dark else surely):
            (darker if dark else others).append(edge.y)
    return min(darker or others, key=lambda y: abs(y - expected), default=None)


def moved(strips: Strips, sides: Sequence[float], within: float) -> float | None:
    """Return the common shift of the books' sides since an earlier view, in [m]; None if too few agree.

    At least two sides, and half of those in view, must agree. Any edge in the picture may be any of the
    sides. The shift in which most sides agree is chosen, the smallest one of several. The median shift of the
    agreeing sides is returned.

    Args:
        strips: averaged rows of the picture, where it shows the shelf next to the held book.
        sides: y of the books' left and right sides in an earlier view, in the shelf frame, in [m].
        within: maximum shift, in [m].
    """
    edges = np.array(all_sides(strips))
    in_view = np.array(
        [y for y in sides if strips.seen(y + within, y - within, STRIP_HEIGHTS_M[1]) > MIN_VISIBLE_SHARE]
    )
    if len(in_view) < 2 or len(edges) == 0:
        return None
    apart = edges[:, None] - in_view
    shifts = apart[np.abs(apart) < within]
    agree = [np.abs(apart - shift).min(axis=0) < SIDE_SHIFT_TOLERANCE_M for shift in shifts]
    best = max(zip(agree, shifts, strict=True), key=lambda a: (a[0].sum(), -abs(a[1])), default=None)
    if best is None or best[0].sum() < max(2, len(in_view) / 2):
        return None
    nearest = np.take_along_axis(apart, np.abs(apart - best[1]).argmin(axis=0)[None], axis=0)[0]
    return float(np.median(nearest[best[0]]))


def side_near(strips: Strips, expected: float) -> float:
    """Return y of the visible edge nearest to an expected side of a book, in the shelf frame, in [m].

    If no edge is visible within `SIDE_SHIFT_TOLERANCE_M` of `expected`, for example between a dark spine and
    a dark slot, `expected` is returned.
    """
    near = [y for y in all_sides(strips) if abs(y - expected) < SIDE_SHIFT_TOLERANCE_M]
    return min(near, key=lambda y: abs(y - expected), default=expected)


def book_end(view: HandView, left: float, thickness: float) -> float | None:
    """Return y of the book end right of the last book in the shelf frame, in [m]; None if none is seen.

    A book end may be as dark as some spines, so that it is recognized by its edge, not by its grey level. Its
    face is further back than the spines, so that the camera must be straight in front of its edge.

    Args:
        view: picture from straight in front of the book end's edge.
        left: y of the last book's right side, in [m].
        thickness: thickness of a book that a slot before the book end would take, in [m].
    """
    strips = _strips(view, LOW_HEIGHTS)
    edges = falling_edges(strips.mirrored())
    fitting = [e for e in edges if SLOT_PLAY_RANGE_M[0] < left - e.y - thickness < SLOT_PLAY_RANGE_M[1]]
    return max(fitting, key=lambda edge: edge.drop).y if fitting else None


def _strips(view: HandView, heights: tuple[float, float]) -> Strips:
    flat = flat_view(view.image, view.camera, view.camera_T_shelf, view.mask, M_PER_PX, heights)
    return upright(strips_of(flat))
