"""From a view of the shelf to spines and gaps, with their sides in millimetres."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from handcart.robotics.perception.books.label_finder import View, flat_view
from handcart.robotics.perception.books.label_reader import Label
from handcart.robotics.perception.books.spine_edges import Strips, falling_edges, strips_of, upright
from handcart.robotics.perception.cameras.camera_model import CameraModel, GreyImage

Floats = NDArray[np.float64]

_M_PER_PX = 0.0003
_HEIGHTS = (
    0.012,
    0.150,
)  # of the shelf's front that is looked at, [m]: every book is taller, the board is lower
_THINNEST, _THICKEST = 0.013, 0.048
_LABEL_HALF_WIDTH = 0.0058
_NARROWEST_GAP = 0.006
_GAP_FROM_HEIGHT = 0.05  # below, the board's top shows in a gap
_LABEL_BELOW, _LABEL_SHARE = 0.06, 0.8
_SLIVER = 0.003
_GAP_BRIGHTNESS = 0.65  # of the spines' in the same view


class Spine(NamedTuple):
    """A spine with both its sides in view: `left` > `right`, y in the shelf frame in [m]."""

    left: float
    right: float
    label: Label | None


class Gap(NamedTuple):
    """A free slot between two spines, or spine and panel: `left` > `right`, y in the shelf frame in [m]."""

    left: float
    right: float

    @property
    def width(self) -> float:
        return self.left - self.right


class SpineView(NamedTuple):
    """What one view showed, from left to right. `eye`: y of the camera, where sides are measured best;
    `left`, `right`: what part of the shelf's front was in view, in [m]."""

    spines: tuple[Spine, ...]
    gaps: tuple[Gap, ...]
    eye: float
    left: float
    right: float


def find_spines(
    image: GreyImage,
    camera: CameraModel,
    camera_T_shelf: Floats,
    labels: Sequence[Label] = (),
    mask: NDArray[np.bool_] | None = None,
) -> SpineView:
    """The spines and gaps in `image`, both sides of which are in view.

    A label makes a spine: its sides are the first edges beside it that run up the whole view. What stands
    between two spines without a label and darker than spines is a gap. `camera_T_shelf` (4, 4) may be a few
    millimetres and degrees off, all positions are then off alike; `mask` (h, w) is True where the image shows
    the shelf. Positions hold at the mean height of the view. Raises ValueError when the camera doesn't look
    at the shelf.
    """
    view = flat_view(image, camera, camera_T_shelf, mask, _M_PER_PX, _HEIGHTS)
    strips = upright(strips_of(view))
    # Whatever edge comes first ends a spine: where its own fall is lost, the next one's stands beside it.
    sides = [edge.y for edge in (*falling_edges(strips), *falling_edges(strips.mirrored()))]
    labelled = _labelled(labels, sides)
    between = _between(labelled, labels, strips, sides, view)
    eye = float(np.linalg.inv(camera_T_shelf)[1, 3])
    spines = sorted([*labelled, *(s for s in between if isinstance(s, Spine))], key=lambda s: -s.left)
    gaps = tuple(g for g in between if isinstance(g, Gap))
    return SpineView(tuple(spines), gaps, eye, view.left, view.left - view.picture.shape[1] * view.m_per_px)


def _labelled(labels: Sequence[Label], sides: Sequence[float]) -> list[Spine]:
    found = []
    for label in labels:
        left = [y for y in sides if y > label.lateral + _LABEL_HALF_WIDTH]
        right = [y for y in sides if y < label.lateral - _LABEL_HALF_WIDTH]
        if left and right and _THINNEST <= min(left) - max(right) <= _THICKEST:
            found.append(Spine(min(left), max(right), label))
    return _without_overlaps(found)


def _without_overlaps(spines: list[Spine]) -> list[Spine]:
    """Two spines that overlap mean a side was missed: neither is sure."""
    ordered = sorted(spines, key=lambda s: -(s.left + s.right))
    clash = {
        i + k
        for i in range(len(ordered) - 1)
        for k in (0, 1)
        if ordered[i].right < ordered[i + 1].left - 0.002
    }
    return [spine for i, spine in enumerate(ordered) if i not in clash]


def _between(
    labelled: Sequence[Spine], labels: Sequence[Label], strips: Strips, sides: Sequence[float], view: View
) -> list[Spine | Gap]:
    """Gaps, panels and spines without a label in what the labelled spines leave free."""
    level = _GAP_BRIGHTNESS * _spine_level(labelled, strips)
    end = view.left - view.picture.shape[1] * view.m_per_px
    lefts, rights = [s.left for s in labelled] + [end], [view.left] + [s.right for s in labelled]
    found: list[Spine | Gap] = []
    for start, stop in zip(rights, lefts, strict=True):
        cuts = [start, *(y for y in sorted(sides, reverse=True) if stop < y < start), stop]
        found += _slots(_runs(cuts, labels, strips, level), start != view.left, stop != end)
    return found


def _slots(runs: Sequence[_Piece], starts_at_spine: bool, ends_at_spine: bool) -> list[Spine | Gap]:
    """The dark runs that something bright ends on both sides, and the bright ones of a book's thickness."""
    found: list[Spine | Gap] = []
    for i, run in enumerate(runs):
        before = runs[i - 1].dark is False if i > 0 else starts_at_spine
        after = runs[i + 1].dark is False if i + 1 < len(runs) else ends_at_spine
        if run.dark and before and after and run.left - run.right >= _NARROWEST_GAP:
            found.append(Gap(run.left, run.right))
        # What touches the view's end may go on there.
        inside = (i > 0 or starts_at_spine) and (i + 1 < len(runs) or ends_at_spine)
        if run.dark is False and inside and _THINNEST <= run.left - run.right <= _THICKEST:
            found.append(Spine(run.left, run.right, None))
    return found


class _Piece(NamedTuple):
    left: float
    right: float
    dark: bool | None


def _runs(cuts: Sequence[float], labels: Sequence[Label], strips: Strips, level: float) -> list[_Piece]:
    """The pieces between the cuts; neighbours that are dark alike, as a slot and a book's side in it, are
    one.
    """
    runs: list[_Piece] = []
    waiting: float | None = None  # left end of a sliver, which is a slot's rather than a spine's
    for left, right in pairwise(cuts):
        if left - right < _SLIVER:
            if runs and runs[-1].dark:
                runs[-1] = runs[-1]._replace(right=right)
            elif waiting is None:
                waiting = left
            continue
        dark = _dark(left, right, labels, strips, level)
        if runs and runs[-1].dark == dark and dark is not False:
            runs[-1] = runs[-1]._replace(right=right)
        else:
            runs.append(_Piece(waiting if dark and waiting is not None else left, right, dark))
        waiting = None
    return runs


def _dark(left: float, right: float, labels: Sequence[Label], strips: Strips, level: float) -> bool | None:
    """Whether there is a slot rather than a spine; None where too little is seen to rule out a label."""
    if any(right < label.lateral < left for label in labels):
        return False
    brightness = strips.brightness(left - 0.001, right + 0.001, _GAP_FROM_HEIGHT)
    if brightness is None or brightness >= level:
        return None if brightness is None else False
    return True if strips.seen(left, right, _LABEL_BELOW) >= _LABEL_SHARE else None


def _spine_level(labelled: Sequence[Spine], strips: Strips) -> float:
    """How bright spines are in this view. Without a sure spine, the brighter half of what is seen."""
    levels = [strips.brightness(s.left - 0.002, s.right + 0.002, _GAP_FROM_HEIGHT) for s in labelled]
    known = [level for level in levels if level is not None]
    if known:
        return float(np.median(known))
    shown = strips.grey[~np.isnan(strips.grey)]
    return float(np.percentile(shown, 75)) if len(shown) else 255.0
