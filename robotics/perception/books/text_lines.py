"""The lines of print on a label."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handcart.robotics.numerics.arrays import ByteArray

_INKED = 0.12  # of the row with the most ink: less is not a line of print
_LEAST_CAP = 0.15  # of a label's width: a lower band is not a line of print


class TextLine(NamedTuple):
    """Line of text on a label.

    `middle` is the distance of its middle below the label's middle, `cap` the height of its capitals, both in
    [px].
    """

    middle: float
    cap: float


def text_lines(page: ByteArray) -> list[TextLine]:
    """Return the lines of text on a label, from top to bottom.

    If no line is found, a single line is returned whose capitals are half as high as the label.

    Args:
        page: (h, w), grey picture of the label without its border, with text running from left to right.
    """
    height, width = page.shape
    rim = max(1, width // 12)
    inner = page[:, rim:-rim]
    white, black = np.percentile(inner, (90, 2))
    inked = (inner < (white + black) / 2).mean(axis=1)
    rows = inked > max(_INKED * float(inked.max()), 0.02)
    ends = np.flatnonzero(np.diff(np.concatenate([[False], rows, [False]]).astype(int)))
    runs = [(int(a), int(b)) for a, b in ends.reshape(-1, 2) if b - a >= _LEAST_CAP * height]
    if not runs:
        return [TextLine(0.0, height / 2)]
    return [TextLine((a + b) / 2 - height / 2, float(b - a)) for a, b in runs]
