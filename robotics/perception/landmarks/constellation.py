"""Which of several landmarks that look alike is which: one place of the base has to explain all of them."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from handcart.robotics.geometry.pose2 import Pose2, wrap

Floats = NDArray[np.float64]

NEAR, NEAR_TURN = 0.010, 0.05  # [m], [rad] within which what is seen may be what is planned there
SIGMA, TURN_SIGMA = 0.002, 0.005  # [m], [rad] of a landmark against the others: glued on, and seen
STRAY = math.log(1e3)  # one mark in so many that look like landmarks isn't in the plan
UNSEEN = math.log(100.0)  # one landmark in so many isn't found in a picture that should show it
CERTAIN = math.log(5e3)
"""By so much likelier than any other an explanation is believed. One stray mark alone is not enough."""
APART, APART_TURN = 0.02, 0.05  # [m], [rad] between places of the base that aren't one
MOVED = math.log(1e-3)  # of a base that somebody moved
MOVED_BY = np.diag([0.3, 0.3, 0.17]) ** 2  # [m², rad²] how far, then


class Kind(NamedTuple):
    """What tells landmarks apart in a picture."""

    height: float
    """Of what it lies on, in the base frame, in [m]."""
    side: float
    """In [m]."""


class Mark(NamedTuple):
    """A landmark of the plan."""

    kind: Kind
    place: Pose2
    """planned_T_mark: seen from a base that stands where it should."""


Sighting = Mapping[Kind, Pose2]
"""base_T_mark of a mark that was seen, by the kinds that it may be of: its height decides where it is."""
Shown = Callable[[Kind, Sequence[Pose2]], NDArray[np.bool_]]
"""Whether marks of a kind at places base_T_mark would have been wholly in one of the pictures."""


class Belief(NamedTuple):
    """Where the base is believed to stand before it looks."""

    planned_T_base: Pose2
    covariance: Floats
    """(3, 3) of x, y in [m] and heading in [rad]."""

    def log_density(self, planned_T_base: Pose2) -> float:
        """Of standing there; somebody may also have moved the base."""
        off = np.subtract(planned_T_base, self.planned_T_base)
        off[2] = wrap(float(off[2]))
        moved = _log_normal(off, self.covariance + MOVED_BY)
        return float(np.logaddexp(_log_normal(off, self.covariance), MOVED + moved))


class Explanation(NamedTuple):
    """What is seen, as seen from one place of the base."""

    planned_T_base: Pose2
    marks: tuple[int | None, ...]
    """Of each sighting which mark of the plan it is; None: none of them."""
    score: float
    """Logarithm of how likely it is, up to what all explanations of these sightings have in common."""

    def rivals(self, other: Explanation) -> bool:
        """Whether the other one has the base elsewhere."""
        one, two = self.planned_T_base, other.planned_T_base
        return one.distance(two) > APART or one.turn(two) > APART_TURN


def explain(
    marks: Sequence[Mark], seen: Sequence[Sighting], belief: Belief, shown: Shown
) -> list[Explanation]:
    """All places of the base from which at least one landmark of the plan is seen, the likeliest first.

    Each pair of a mark of the plan and one that was seen says where the base stands; what else was seen, what
    should have been, and where the base is believed to stand then tell how likely that is (data association
    by joint compatibility: Neira and Tardós, 2001, with Bar-Shalom's costs of what is missing and false).

    Args:
        marks: of the plan.
        seen: in all pictures together, each mark once.
        belief: where the base stands, before it looked.
        shown: whether a mark somewhere would have been seen.
    """
    found: dict[tuple[int | None, ...], Explanation] = {}
    for sighting in seen:
        for mark in marks:
            if mark.kind in sighting:
                guess = mark.place.compose(sighting[mark.kind].inverse())
                one = _explained(guess, marks, seen, belief, shown)
                if one.score > found.get(one.marks, one._replace(score=-math.inf)).score:
                    found[one.marks] = one
    return sorted(found.values(), key=lambda each: -each.score)


def rivals(explanations: Sequence[Explanation]) -> list[Explanation]:
    """The best one, then those which have the base elsewhere and are hardly less likely."""
    best = explanations[0]
    close = [each for each in explanations if each.score > best.score - CERTAIN]
    return [best, *(each for each in close if each.rivals(best))]


def _explained(
    guess: Pose2, marks: Sequence[Mark], seen: Sequence[Sighting], belief: Belief, shown: Shown
) -> Explanation:
    chosen = [_mark_at(guess, marks, each) for each in seen]
    pairs = [(marks[i], each[marks[i].kind]) for i, each in zip(chosen, seen, strict=True) if i is not None]
    place = _fit(pairs) if pairs else guess
    misfit = sum(0.5 * (place.compose(at).distance(mark.place) / SIGMA) ** 2 for mark, at in pairs)
    missing = _missing(place, [mark for i, mark in enumerate(marks) if i not in chosen], shown)
    stray = chosen.count(None)
    score = belief.log_density(place) - misfit - stray * STRAY - missing * UNSEEN
    return Explanation(place, tuple(chosen), score)


def _mark_at(planned_T_base: Pose2, marks: Sequence[Mark], seen: Sighting) -> int | None:
    """Which mark of the plan stands where one is seen from there. Marks of a plan don't overlap."""
    for i, mark in enumerate(marks):
        if mark.kind in seen:
            at = planned_T_base.compose(seen[mark.kind])
            if at.distance(mark.place) < NEAR and at.turn(mark.place) < NEAR_TURN:
                return i
    return None


def _missing(planned_T_base: Pose2, marks: Sequence[Mark], shown: Shown) -> int:
    """How many of these marks were to be seen from there."""
    to_base, count = planned_T_base.inverse(), 0
    for kind in {mark.kind: None for mark in marks}:
        places = [to_base.compose(mark.place) for mark in marks if mark.kind == kind]
        count += int(np.count_nonzero(shown(kind, places)))
    return count


def _fit(pairs: Sequence[tuple[Mark, Pose2]]) -> Pose2:
    """planned_T_base that brings what is seen nearest to the plan: Procrustes, the headings count as well."""
    there = np.array([mark.place for mark, _ in pairs])
    here = np.array([at for _, at in pairs])
    middle, other = here[:, :2].mean(axis=0), there[:, :2].mean(axis=0)
    a, b = here[:, :2] - middle, there[:, :2] - other
    turns, weight = there[:, 2] - here[:, 2], (SIGMA / TURN_SIGMA) ** 2
    cos = float((a * b).sum() + weight * np.cos(turns).sum())
    sin = float((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum() + weight * np.sin(turns).sum())
    turn = Pose2(0.0, 0.0, math.atan2(sin, cos))
    x, y = (other - turn.apply(middle[None])[0]).tolist()
    return turn._replace(x=x, y=y)


def _log_normal(off: Floats, covariance: Floats) -> float:
    size = float(off @ np.linalg.solve(covariance, off))
    return -0.5 * (size + float(np.linalg.slogdet(covariance)[1]))
