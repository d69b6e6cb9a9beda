"""Arrows and names of places on a map, placed without overlap."""

from __future__ import annotations

import math
from collections.abc import Mapping
from itertools import product
from typing import Any

import numpy as np

from .palette import BLACK
from .plain_text import plain

LETTER_WIDTH_EM = 0.62  # mean width of a letter, relative to the font size
LINE_HEIGHT_EM = 1.3  # relative to the font size
LABEL_DISTANCE_PT = 4.0  # from the place
ARROW_LENGTH_PT = 10.0
LABEL_DIRECTIONS = tuple(
    (math.cos(math.radians(turn)), math.sin(math.radians(turn))) for turn in range(0, 360, 45)
)

Box = tuple[float, float, float, float]


def draw_places(axis: Any, places: Mapping[str, tuple[float, float, float]], size: float = 8.0) -> None:
    """Draw an arrow in the heading of each place, and its name, preferably behind the place.

    A name without free space is omitted. Call this when the axis has its final limits and size.

    Args:
        axis: matplotlib axis, in units of [m].
        places: x, y in [m] and heading in [rad] of each place, by name.
        size: font size, in [pt].
    """
    (left, right), (low, high) = axis.get_xlim(), axis.get_ylim()
    frame = axis.get_position()
    wide, tall = (72.0 * inch for inch in axis.figure.get_size_inches())
    scale = min(wide * frame.width / (right - left), tall * frame.height / (high - low))  # [pt] a metre
    paper = (0.0, 0.0, (right - left) * scale, (high - low) * scale)
    at = {name: ((x - left) * scale, (y - low) * scale) for name, (x, y, _) in places.items()}
    taken: list[Box] = []
    for name, (x, y, heading) in places.items():
        tip = ARROW_LENGTH_PT * math.cos(heading), ARROW_LENGTH_PT * math.sin(heading)
        arrow = {"arrowstyle": "<|-", "color": BLACK, "shrinkA": 0.0, "shrinkB": 0.0}
        axis.annotate("", (x, y), tip, textcoords="offset points", arrowprops=arrow)
        ends = np.array([at[name], np.add(at[name], tip)])
        taken.append((*(ends.min(axis=0) - 2.0).tolist(), *(ends.max(axis=0) + 2.0).tolist()))
    for name, (x, y, heading) in places.items():
        behind = sorted(
            LABEL_DIRECTIONS,
            key=lambda way: round(way[0] * math.cos(heading) + way[1] * math.sin(heading), 3),
        )
        for away, (dx, dy) in product((LABEL_DISTANCE_PT, 2.5 * LABEL_DISTANCE_PT), behind):
            half = LETTER_WIDTH_EM * size * len(name) / 2.0, LINE_HEIGHT_EM * size / 2.0
            middle = at[name][0] + dx * (away + half[0]), at[name][1] + dy * (away + half[1])
            box = middle[0] - half[0], middle[1] - half[1], middle[0] + half[0], middle[1] + half[1]
            if _inside(box, paper) and not any(_over(box, other) for other in taken):
                taken.append(box)
                offset = middle[0] - at[name][0], middle[1] - at[name][1]
                axis.annotate(
                    plain(name),
                    (x, y),
                    offset,
                    textcoords="offset points",
                    ha="center",
                    va="center",
                    fontsize=size,
                    bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.7, "pad": 0.8},
                )
                break


def _inside(box: Box, paper: Box) -> bool:
    return box[0] >= paper[0] and box[1] >= paper[1] and box[2] <= paper[2] and box[3] <= paper[3]


def _over(one: Box, other: Box) -> bool:
    return one[0] < other[2] and other[0] < one[2] and one[1] < other[3] and other[1] < one[3]
