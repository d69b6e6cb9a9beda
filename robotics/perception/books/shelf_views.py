"""Several overlapping views of a shelf, fused into one reading of its books and gaps."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from handcart.robotics.perception.books.call_number import CallNumber
from handcart.robotics.perception.books.label_reader import Label
from handcart.robotics.perception.books.spines import Gap, Spine, SpineView

_SAME_CENTRE, _SAME_WIDTH = 0.008, 0.003  # of one book in two aligned views
_POSE_ERROR = 0.020  # at most, between views
_EDGE_SIGMA, _PARALLAX = 0.0002, 0.006  # a side's error: constant, and for each metre from the camera's axis
_OVERLAP = 0.004


class ShelfBook(NamedTuple):
    """A book on the shelf: `left` > `right`, y in the shelf frame in [m]; `confidence` 0..1 of its call
    number; `views`: how many showed it whole.
    """

    left: float
    right: float
    call_number: CallNumber | None
    confidence: float
    views: int

    @property
    def centre(self) -> float:
        return (self.left + self.right) / 2


class ShelfReading(NamedTuple):
    """What stands on a shelf, from left to right. `offsets` [m] were added to each view's positions."""

    books: tuple[ShelfBook, ...]
    gaps: tuple[Gap, ...]
    offsets: tuple[float, ...]


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
    """One reading of all views. Each view's lateral position may be a few millimetres off: the views are
    aligned by the books that they share, and all together keep their mean position.

    With `fuse` False nothing is aligned, averaged or voted on: each book and gap is as the first view saw it.
    """
    offsets = _offsets(views) if fuse else np.zeros(len(views))
    spines = _groups(_sightings(views, offsets, [view.spines for view in views]))
    gaps = _groups(_sightings(views, offsets, [view.gaps for view in views]))
    if not fuse:
        spines, gaps = ([[min(g, key=lambda s: s.view)] for g in groups] for groups in (spines, gaps))
    kept = [gap for gap in gaps if not any(_denies(spine, gap) for spine in spines)]
    kept_spines = [spine for spine in spines if not any(_denies(gap, spine) for gap in kept)]
    return ShelfReading(
        tuple(_book(group) for group in kept_spines),
        tuple(Gap(*_sides(group)) for group in kept),
        tuple(offsets.tolist()),
    )


def fuse_labels(labels: Iterable[Label]) -> tuple[CallNumber | None, float]:
    """The call number that several readings of one label speak for, and its share of their confidence.

    None when nothing was read, or when the best has no more than half of what was.
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


def _offsets(views: Sequence[SpineView]) -> NDArray[np.float64]:
    """Least squares over the pairs of views that share books; a weak pull to zero fixes what is left free."""
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
    """How much farther left the first view puts each book that both show: of one call number and one
    thickness.
    """
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


def _sightings(
    views: Sequence[SpineView], offsets: NDArray[np.float64], things: Sequence[Sequence[Spine | Gap]]
) -> list[_Sighting]:
    return [
        _Sighting(
            i, t.left + offset, t.right + offset, view.eye + offset, t.label if isinstance(t, Spine) else None
        )
        for i, (view, offset, seen) in enumerate(zip(views, offsets.tolist(), things, strict=True))
        for t in seen
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


def _denies(first: Sequence[_Sighting], second: Sequence[_Sighting]) -> bool:
    """Whether two things claim one place and the first has the better claim: a label, a straighter look."""
    (left, right), (other_left, other_right) = _sides(first), _sides(second)
    if min(left, other_left) - max(right, other_right) < _OVERLAP:
        return False
    claims = [
        (any(s.label is not None for s in group), max(s.weight for s in group)) for group in (first, second)
    ]
    return claims[0] > claims[1]


def _sides(group: Sequence[_Sighting]) -> tuple[float, float]:
    weights = [s.weight for s in group]
    left, right = (np.average([s[k] for s in group], weights=weights) for k in (1, 2))
    return float(left), float(right)


def _book(group: Sequence[_Sighting]) -> ShelfBook:
    number, confidence = fuse_labels(s.label for s in group if s.label is not None)
    return ShelfBook(*_sides(group), number, confidence, len({s.view for s in group}))
