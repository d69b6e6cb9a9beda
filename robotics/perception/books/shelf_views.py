"""Several overlapping views of a shelf, fused into one reading of its books and gaps."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from handcart.robotics.numerics.arrays import FloatArray
from handcart.robotics.perception.books.call_number import CallNumber
from handcart.robotics.perception.books.label_reader import Label
from handcart.robotics.perception.books.slots import MIN_SLOT_M, Gap
from handcart.robotics.perception.books.spines import Spine, SpineView

_SAME_CENTRE, _SAME_WIDTH = 0.008, 0.003  # of one book in two aligned views
_POSE_ERROR = 0.020  # at most, between views
_EDGE_SIGMA, _PARALLAX = 0.0002, 0.006  # a side's error: constant, and for each metre from the camera's axis


class ShelfBook(NamedTuple):
    """Book on the shelf, fused from one or several views.

    `left` > `right` are y of its sides in the shelf frame, in [m]. `confidence`, 0 to 1, is that of its call
    number. `views` is the number of views that showed the book completely.
    """

    left: float
    right: float
    call_number: CallNumber | None
    confidence: float
    views: int

    @property
    def centre(self) -> float:
        """Lateral position y of the middle between the book's edges, in the shelf frame, in [m]."""
        return (self.left + self.right) / 2


class ShelfReading(NamedTuple):
    """Contents of a shelf, as read in one or several views.

    `books` have labels, and are from left to right, like the `gaps` between them. `offsets` has one value for
    each view, in [m], which was added to the view's lateral positions y.
    """

    books: tuple[ShelfBook, ...]
    gaps: tuple[Gap, ...]
    offsets: tuple[float, ...]

    @property
    def intervals(self) -> tuple[Gap, ...]:
        """Intervals between neighbouring labelled books, which are free slots or contain things without a
        label.
        """
        between = (Gap(a.right, b.left) for a, b in pairwise(self.books))
        return tuple(gap for gap in between if gap.width >= MIN_SLOT_M)


class _Sighting(NamedTuple):
    view: int
    left: float
    right: float
    eye: float
    label: Label | None

    @property
    def centre(self) -> float:
        return (self.left + self.right) / 2

    @property
    def weight(self) -> float:
        return 1.0 / (_EDGE_SIGMA**2 + (_PARALLAX * (self.centre - self.eye)) ** 2)


def fuse_views(views: Sequence[SpineView], fuse: bool = True) -> ShelfReading:
    """Fuse several views of a shelf into one reading.

    The lateral positions of each view may be off by a few millimetres. Therefore the views are aligned by the
    books that they share; the mean position of all views stays. The result contains no gaps: these are found
    by `find_slots`. With `fuse` False, nothing is aligned or averaged: each book is as in the first view that
    shows it.
    """
    offsets = _offsets(views) if fuse else np.zeros(len(views))
    groups = _groups(_sightings(views, offsets))
    if not fuse:
        groups = [[min(group, key=lambda s: s.view)] for group in groups]
    return ShelfReading(tuple(_book(group) for group in groups), (), tuple(offsets.tolist()))


def fuse_labels(labels: Iterable[Label]) -> tuple[CallNumber | None, float]:
    """Return the most probable call number by several readings of one label, and its share of confidence, 0
    to 1.

    The share is the confidence of the readings with this number divided by that of all readings with a
    number.

    The number is None if nothing was read, or if no number has a share of more than a half.
    """
    votes: dict[CallNumber, float] = {}
    for label in labels:
        if label.call_number is not None:
            votes[label.call_number] = votes.get(label.call_number, 0.0) + label.confidence
    if not votes:
        return None, 0.0
    best = max(votes, key=lambda number: (votes[number], number))
    share = votes[best] / sum(votes.values())
    return (best, share) if share > 0.5 else (None, 0.0)


def _offsets(views: Sequence[SpineView]) -> FloatArray:
    """Return the offset (n,) of each view, in [m], by least squares over the pairs that share books.

    A weak pull to zero fixes what is left free.
    """
    rows, values = [1e-3 * np.eye(len(views))], [np.zeros(len(views))]
    for i, first in enumerate(views):
        for j in range(i + 1, len(views)):
            apart = _differences(first.spines, views[j].spines)
            if apart:
                row = np.zeros((1, len(views)))
                row[0, i], row[0, j] = 1.0, -1.0
                weight = np.sqrt(len(apart))
                rows.append(row * weight)
                values.append(np.array([-float(np.median(apart)) * weight]))
    return np.linalg.lstsq(np.vstack(rows), np.concatenate(values), rcond=None)[0].astype(np.float64)


def _differences(first: Sequence[Spine], second: Sequence[Spine]) -> list[float]:
    """Return how much farther left, in [m], the first view has each common book: its y less the other's."""
    apart = []
    for a in first:
        for b in second:
            difference = (a.left + a.right - b.left - b.right) / 2
            alike = abs((a.left - a.right) - (b.left - b.right)) < _SAME_WIDTH
            if (
                alike
                and abs(difference) < _POSE_ERROR
                and _number(a) is not None
                and _number(a) == _number(b)
            ):
                apart.append(difference)
    return apart


def _number(spine: Spine) -> CallNumber | None:
    return spine.label.call_number if spine.label is not None else None


def _sightings(views: Sequence[SpineView], offsets: FloatArray) -> list[_Sighting]:
    return [
        _Sighting(i, spine.left + offset, spine.right + offset, view.eye + offset, spine.label)
        for i, (view, offset) in enumerate(zip(views, offsets.tolist(), strict=True))
        for spine in view.spines
    ]


def _groups(sightings: Sequence[_Sighting]) -> list[list[_Sighting]]:
    """Sightings of the same thing, from left to right; the best seen come first and gather the others."""
    groups: list[list[_Sighting]] = []
    for sighting in sorted(sightings, key=lambda s: (-s.weight, s.view)):
        near = [group for group in groups if abs(group[0].centre - sighting.centre) < _SAME_CENTRE]
        if near:
            min(near, key=lambda group: abs(group[0].centre - sighting.centre)).append(sighting)
        else:
            groups.append([sighting])
    return sorted(groups, key=lambda group: -group[0].centre)


def _sides(group: Sequence[_Sighting]) -> tuple[float, float]:
    weights = [s.weight for s in group]
    left, right = (np.average([s[k] for s in group], weights=weights) for k in (1, 2))
    return float(left), float(right)


def _book(group: Sequence[_Sighting]) -> ShelfBook:
    number, confidence = fuse_labels(s.label for s in group if s.label is not None)
    return ShelfBook(*_sides(group), number, confidence, len({s.view for s in group}))
