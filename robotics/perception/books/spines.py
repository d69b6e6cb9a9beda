"""Detection of spines in a view of the shelf, with their sides in millimetres."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from handcart.robotics.numerics.arrays import BoolArray, ByteArray, FloatArray
from handcart.robotics.perception.books.call_number import CallNumber
from handcart.robotics.perception.books.flat_view import flat_view
from handcart.robotics.perception.books.label_reader import Label
from handcart.robotics.perception.books.spine_edges import Strips, all_sides, strips_of, upright
from handcart.robotics.perception.cameras.camera_model import CameraModel

_M_PER_PX = 0.0003
_HEIGHTS = (0.003, 0.150)  # of the shelf's front that is looked at, [m]: every book is taller
_EDGES_FROM = 0.012  # [m]: below, the board shows between books
_THINNEST, _THICKEST = 0.005, 0.085
MIN_LEAN_RAD = math.radians(3.0)  # a smaller turn may be the camera's roll
_OFF_MIDDLE, _OFF_THICKNESS = (
    0.004,
    0.0025,
)  # [m]: of a label on its spine; of a book, as the catalogue has it
_COMPARED = 6  # sightings of books whose thickness is known, at least
_RIM = 0.0008  # of a label that may look like a spine's side, [m]


class Spine(NamedTuple):
    """Spine of a book between its sides `left` > `right`, y in the shelf frame, in [m]."""

    left: float
    right: float
    label: Label | None
    both: bool = True
    """True if both sides were seen; False if one was, and the catalogue has the thickness."""


class SpineView(NamedTuple):
    """Result of finding spines in one view of the shelf; all positions are y in the shelf frame, in [m].

    `spines` are the spines with a label, from left to right. `sides` are the positions of all vertical edges.
    `strips` contain the grey levels of the view. `eye` is the position of the camera; sides near it are
    measured best. `left` and `right` are the ends of the visible part of the shelf's front. `leaning` are
    labels of leaning books, whose sides are unknown.
    """

    spines: tuple[Spine, ...]
    sides: tuple[float, ...]
    strips: Strips
    eye: float
    left: float
    right: float
    leaning: tuple[Label, ...] = ()


def find_spines(
    image: ByteArray,
    camera: CameraModel,
    camera_T_shelf: FloatArray,
    labels: Sequence[Label] = (),
    mask: BoolArray | None = None,
    thicknesses: Mapping[CallNumber, float] = MappingProxyType({}),
) -> SpineView:
    """Return the labelled spines in an image that are completely visible.

    The sides of a spine are the first edges next to a label that run up the complete view. If the thickness
    of the book is known, the sides are edges with this distance between them, because a dark spine next to a
    dark slot shows only one edge. A single view can't identify the things between two spines; see
    `find_slots`. Positions are those at the mean height of the view.

    Args:
        image: (h, w), grey.
        camera: model of the camera.
        camera_T_shelf: (4, 4) pose of the shelf, in [m]; errors of a few millimetres and degrees shift all
            positions alike.
        labels: labels of the image, in the shelf frame.
        mask: (h, w) True where the image shows the shelf; None: everywhere.
        thicknesses: known thicknesses of books, in [m].

    Raises:
        ValueError: the camera doesn't look at the shelf.
    """
    view = flat_view(image, camera, camera_T_shelf, mask, _M_PER_PX, _HEIGHTS)
    strips = upright(strips_of(view))
    above = strips.above(_EDGES_FROM)
    # The first edge ends a spine: where its own fall is lost, the next one's rise is beside it.
    sides = all_sides(above)
    eye = float(np.linalg.inv(camera_T_shelf)[1, 3])
    right = view.left - view.picture.shape[1] * view.m_per_px
    leaning = tuple(label for label in labels if abs(label.lean) > MIN_LEAN_RAD)
    spines = _labelled([label for label in labels if abs(label.lean) <= MIN_LEAN_RAD], sides, thicknesses)
    return SpineView(spines, tuple(sorted(sides)), strips, eye, view.left, right, leaning)


def scale_of(views: Sequence[SpineView], thicknesses: Mapping[CallNumber, float]) -> float:
    """Return the ratio of the widths of spines as seen to their thicknesses in the catalogue; 1 for fewer
    than six spines.

    If the camera differs slightly from its file, all widths appear too large or too small by the same factor.

    Args:
        views: views of the shelf.
        thicknesses: thicknesses of books in the catalogue, in [m].
    """
    seen, known = [], []
    for spine in (spine for view in views for spine in view.spines if spine.both and spine.label):
        assert spine.label is not None
        thickness = thicknesses.get(spine.label.call_number) if spine.label.call_number else None
        if thickness is not None:
            seen.append(spine.left - spine.right)
            known.append(thickness)
    if len(known) < _COMPARED:
        return 1.0
    return float(np.dot(seen, known) / np.dot(known, known))


def _labelled(
    labels: Sequence[Label], sides: Sequence[float], thicknesses: Mapping[CallNumber, float]
) -> tuple[Spine, ...]:
    found: dict[tuple[float, float], Spine] = {}
    # Of several labels on one spine, the one that was read counts.
    for label in sorted(labels, key=lambda label_: (label_.call_number is not None, label_.confidence)):
        thickness = thicknesses.get(label.call_number) if label.call_number is not None else None
        spine = _first_edges(label, sides) if thickness is None else _as_thick(label, sides, thickness)
        if spine is not None:
            found[spine.left, spine.right] = spine
    return tuple(_without_overlaps(list(found.values())))


def _first_edges(label: Label, sides: Sequence[float]) -> Spine | None:
    half = label.width / 2 - _RIM
    left = min((y for y in sides if y > label.lateral + half), default=math.inf)
    right = max((y for y in sides if y < label.lateral - half), default=-math.inf)
    return Spine(left, right, label) if _THINNEST <= left - right <= _THICKEST else None


def _as_thick(label: Label, sides: Sequence[float], thickness: float) -> Spine | None:
    """Two edges as far apart as the book is thick, the label about in their middle; or one of them."""
    lefts, rights = (
        [y for y in sides if abs(y - label.lateral - half) < _OFF_MIDDLE]
        for half in (thickness / 2, -thickness / 2)
    )
    pairs = [Spine(a, b, label) for a in lefts for b in rights if abs(a - b - thickness) < _OFF_THICKNESS]
    pairs = pairs or [
        *(Spine(a, a - thickness, label, both=False) for a in lefts),
        *(Spine(b + thickness, b, label, both=False) for b in rights),
    ]
    return min(pairs, key=lambda one: abs((one.left + one.right) / 2 - label.lateral), default=None)


def _without_overlaps(spines: list[Spine]) -> list[Spine]:
    """Return the spines from left to right, without overlapping ones: there a side was missed, and neither is
    sure.
    """
    ordered = sorted(spines, key=lambda s: -(s.left + s.right))
    clash = {
        i + k
        for i in range(len(ordered) - 1)
        for k in (0, 1)
        if ordered[i].right < ordered[i + 1].left - 0.002
    }
    return [spine for i, spine in enumerate(ordered) if i not in clash]
