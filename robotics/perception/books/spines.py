"""From a view of the shelf to spines, with their sides in millimetres."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from handcart.robotics.perception.books.label_finder import flat_view
from handcart.robotics.perception.books.label_reader import Label
from handcart.robotics.perception.books.spine_edges import Strips, falling_edges, strips_of, upright
from handcart.robotics.perception.cameras.camera_model import CameraModel, GreyImage

Floats = NDArray[np.float64]

_M_PER_PX = 0.0003
_HEIGHTS = (0.003, 0.150)  # of the shelf's front that is looked at, [m]: every book is taller
_EDGES_FROM = 0.012  # [m]: below, the board shows between books
_THINNEST, _THICKEST = 0.005, 0.085
_SEAM = 0.0018  # [m] between the spines of two books that touch, or spine and cover, at most
LEANS = math.radians(3.0)  # what is turned less may be the camera's roll
_RIM = 0.0008  # of a label that may look like a spine's side, [m]


class Spine(NamedTuple):
    """A spine with both its sides in view: `left` > `right`, y in the shelf frame in [m]."""

    left: float
    right: float
    label: Label | None


class SpineView(NamedTuple):
    """What one view showed: labelled spines from left to right, and all `sides`, y in [m] of edges that run
    up the view. `strips` is what was seen there. `eye`: y of the camera, where sides are measured best;
    `left`, `right`: what part of the shelf's front was in view, in [m]. `leaning`: labels of books that lean,
    whose sides aren't known."""

    spines: tuple[Spine, ...]
    sides: tuple[float, ...]
    strips: Strips
    eye: float
    left: float
    right: float
    leaning: tuple[Label, ...] = ()


def find_spines(
    image: GreyImage,
    camera: CameraModel,
    camera_T_shelf: Floats,
    labels: Sequence[Label] = (),
    mask: NDArray[np.bool_] | None = None,
) -> SpineView:
    """The labelled spines in `image`, both sides of which are in view.

    A label makes a spine: its sides are the first edges beside it that run up the whole view. What stands
    between two spines one view can't tell, see `find_slots`. `camera_T_shelf` (4, 4) may be a few millimetres
    and degrees off, all positions are then off alike; `mask` (h, w) is True where the image shows the shelf.
    Positions hold at the mean height of the view. Raises ValueError when the camera doesn't look at the
    shelf.
    """
    view = flat_view(image, camera, camera_T_shelf, mask, _M_PER_PX, _HEIGHTS)
    strips = upright(strips_of(view))
    above = strips.above(_EDGES_FROM)
    # Whatever edge comes first ends a spine: where its own fall is lost, the next one's stands beside it.
    sides = _seams(
        [edge.y for edge in falling_edges(above)], [edge.y for edge in falling_edges(above.mirrored())]
    )
    eye = float(np.linalg.inv(camera_T_shelf)[1, 3])
    right = view.left - view.picture.shape[1] * view.m_per_px
    leaning = tuple(label for label in labels if abs(label.lean) > LEANS)
    spines = _labelled([label for label in labels if abs(label.lean) <= LEANS], sides)
    return SpineView(spines, tuple(sorted(sides)), strips, eye, view.left, right, leaning)


def _seams(falls: Sequence[float], rises: Sequence[float]) -> list[float]:
    """All edges; a fall, seen from the left, and a rise next to it are one: the dark seam of two sides."""
    sides, left = [], sorted(rises, reverse=True)
    for fall in sorted(falls, reverse=True):
        rise = next((y for y in left if 0.0 <= fall - y < _SEAM), None)
        if rise is not None:
            left.remove(rise)
        sides.append(fall if rise is None else (fall + rise) / 2)
    return [*sides, *left]


def _labelled(labels: Sequence[Label], sides: Sequence[float]) -> tuple[Spine, ...]:
    found: dict[tuple[float, float], Spine] = {}
    # Of several on one spine, a tag say, the one that was read counts.
    for label in sorted(labels, key=lambda each: (each.call_number is not None, each.confidence)):
        half = label.width / 2 - _RIM
        left = [y for y in sides if y > label.lateral + half]
        right = [y for y in sides if y < label.lateral - half]
        if left and right and _THINNEST <= min(left) - max(right) <= _THICKEST:
            found[min(left), max(right)] = Spine(min(left), max(right), label)
    return tuple(_without_overlaps(list(found.values())))


def _without_overlaps(spines: list[Spine]) -> list[Spine]:
    """From left to right; two spines that overlap mean a side was missed: neither is sure."""
    ordered = sorted(spines, key=lambda s: -(s.left + s.right))
    clash = {
        i + k
        for i in range(len(ordered) - 1)
        for k in (0, 1)
        if ordered[i].right < ordered[i + 1].left - 0.002
    }
    return [spine for i, spine in enumerate(ordered) if i not in clash]
