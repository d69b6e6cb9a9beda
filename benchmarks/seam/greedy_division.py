"""Division of a path by Shin's rule (2005), for comparison with the exact one."""

from __future__ import annotations

import numpy as np

from handcart.robotics.manipulation.arms.placement_scores import PlacementScores
from handcart.robotics.manipulation.placement.division_programs import run_end, segment_score
from handcart.robotics.manipulation.placement.placement_division import (
    Division,
    PathSegment,
    score_arrays,
    score_segments,
    stuck_at,
)
from handcart.robotics.numerics.arrays import BoolArray, FloatArray, SingleArray
from handcart.robotics.numerics.compiled import compiled


def greedy_division(scores: PlacementScores, lengths: FloatArray) -> Division:
    """Divide by the paper's rule: take the placement with the greatest integral on the remaining path, and
    repeat.

    The paper doesn't define the ends of a segment. Here it begins at the end of the one before, and ends
    where the placement becomes unusable.

    Raises:
        Untrackable: no placement continues from some point.
    """
    values, usable, joined, steps = score_arrays(scores, lengths)
    first, segments = 0, []
    while first < len(steps):
        placement, last = _heaviest_run(values, usable, joined, steps, first)
        if last <= first:
            raise stuck_at(scores, first)
        segments.append(PathSegment(int(placement), first, int(last)))
        first = int(last)
    return score_segments(segments, values, steps)


@compiled
def _heaviest_run(
    values: SingleArray, usable: BoolArray, joined: BoolArray, steps: FloatArray, first: int
) -> tuple[int, int]:
    """Return the placement whose whole run from the point `first` has the greatest integral, and its end."""
    placement, end, heaviest = -1, first, -np.inf
    for b in range(values.shape[1]):
        last = run_end(usable, joined, first, b)
        if last > first:
            total = segment_score(values, steps, b, first, last)
            if total > heaviest:
                placement, end, heaviest = b, last, total
    return placement, end
