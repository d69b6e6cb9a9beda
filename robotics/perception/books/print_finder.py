"""Finding print on bright ground, where a paper label doesn't show against its cover."""

from __future__ import annotations

import cv2
import numpy as np

from handcart.robotics.numerics.arrays import ByteArray
from handcart.robotics.perception.books.flat_view import FlatView
from handcart.robotics.perception.books.label_box import LabelBox

_STROKE = 0.0035  # [m]: print is thinner
_GROUND, _INK = 170, 50  # of bright ground at least, and by how much print is darker, in grey levels
_BETWEEN_LETTERS, _BESIDE = 0.006, 0.001  # [m] that are bridged along and across a line
_CAPS, _LENGTHS = (0.0022, 0.0125), (0.008, 0.085)  # of a line across and along the spine, [m]
_MARGIN = 0.5  # around print, in heights of a capital
_SEAM = 0.85  # of the ground's grey
_APART = 1.2  # lines of one label, at most, in heights of a capital


def find_prints(view: FlatView) -> list[LabelBox]:
    """Return boxes, with a margin, around dark print of the size of a call number, in the shelf frame.

    Lines of print next to each other get one common box.
    """
    size = max(3, round(_STROKE / view.m_per_px))
    ground = cv2.morphologyEx(view.picture, cv2.MORPH_CLOSE, np.ones((size, size), np.uint8))
    ink = (ground.astype(np.int16) - view.picture > _INK) & (ground >= _GROUND) & view.seen
    bridge = np.ones([round(m / view.m_per_px) for m in (_BETWEEN_LETTERS, _BESIDE)], np.uint8)
    joined = cv2.morphologyEx(ink.astype(np.uint8), cv2.MORPH_CLOSE, bridge)
    stats = cv2.connectedComponentsWithStats(joined, connectivity=4)[2][1:]
    lines = []
    for x, y, width, height, _ in stats.tolist():
        cap, length = width * view.m_per_px, height * view.m_per_px
        if _CAPS[0] <= cap <= _CAPS[1] and _LENGTHS[0] <= length <= _LENGTHS[1]:
            lines.append((x, y, x + width, y + height))
    return [_box(block, view) for block in _blocks(lines, view.picture)]


def _blocks(
    lines: list[tuple[int, int, int, int]], picture: ByteArray
) -> list[tuple[int, int, int, int, int]]:
    """Return left, top, right, bottom of neighbouring lines, and the height of capitals, in [px]."""
    blocks: list[tuple[int, int, int, int, int]] = []
    for left, top, right, bottom in sorted(lines):
        cap = right - left
        for i, (x0, y0, x1, y1, other) in enumerate(blocks):
            beside = min(bottom, y1) - max(top, y0) > 0.5 * min(bottom - top, y1 - y0)
            near = left - x1 < _APART * cap and 0.6 < cap / other < 1.6
            if beside and near and not _seam(picture[:, x1:left]):
                blocks[i] = (x0, min(y0, top), right, max(y1, bottom), max(cap, other))
                break
        else:
            blocks.append((left, top, right, bottom, cap))
    return blocks


def _seam(between: ByteArray) -> bool:
    """Return True if a dark line, the sides of two books, runs up the view."""
    columns = np.median(between, axis=0)
    return bool(len(columns) and columns.min() < _SEAM * columns.max())


def _box(block: tuple[int, int, int, int, int], view: FlatView) -> LabelBox:
    left, top, right, bottom, cap = block
    centre = (view.left - (left + right) / 2 * view.m_per_px, view.top - (top + bottom) / 2 * view.m_per_px)
    margin = 2 * _MARGIN * cap
    width, length = (right - left + margin) * view.m_per_px, (bottom - top + margin) * view.m_per_px
    return LabelBox(centre, (0.0, -1.0), length, width, False)
