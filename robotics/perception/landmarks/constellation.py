"""Identification of landmarks that look alike: one pose of the base has to explain all of them."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from handcart.robotics.geometry.pose2 import Pose2, wrap
from handcart.robotics.numerics.arrays import BoolArray, FloatArray

NEAR, NEAR_TURN = 0.010, 0.05  # [m], [rad] within which what is seen may be what is planned there
SIGMA, TURN_SIGMA = 0.002, 0.005  # [m], [rad] of a landmark against the others: glued on, and seen
STRAY_LOG_COST = math.log(1e3)  # one mark in so many that look like landmarks isn't in the plan
UNSEEN_LOG_COST = math.log(100.0)  # one landmark in so many isn't found in a picture that should show it
MIN_LOG_RATIO = math.log(5e3)
"""Minimum log-likelihood ratio to any other explanation. One stray mark alone does not reach it."""
APART, APART_TURN = 0.02, 0.05  # [m], [rad] between places of the base that aren't one
MOVED_LOG_SHARE = math.log(1e-3)  # of a base that was moved
MOVED_BY = np.diag([0.3, 0.3, 0.17]) ** 2  # [m², rad²] how far, then


class Kind(NamedTuple):
    """Kind of square landmarks, given by their size and by the height of the surface on which they lie."""

    height: float
    """Height (z) in the base frame of the surface on which the landmark lies, in [m]."""
    side: float
    """Side of the landmark, in [m]."""


class PlannedMark(NamedTuple):
    """Landmark that the robot expects to see at a planned pose of its base."""

    kind: Kind
    place: Pose2
    """planned_T_mark: pose as seen from a base at its planned pose."""


Sighting = Mapping[Kind, Pose2]
"""Pose base_T_mark of a mark that was seen, by each kind it may be; the pose depends on the kind's height."""
Shown = Callable[[Kind, Sequence[Pose2]], BoolArray]
"""Function that returns a mask (n,) of marks that would have been completely in one of the pictures.

Its arguments are the kind of all n marks and their base_T_mark.
"""


class BasePrior(NamedTuple):
    """Expected pose of the base before a measurement by landmarks, with its accuracy, in the frame of the
    planned base.
    """

    planned_T_base: Pose2
    covariance: FloatArray
    """(3, 3) of x, y in the planned base frame in [m] and heading in [rad]."""

    def log_density(self, planned_T_base: Pose2) -> float:
        """Return the logarithm of the probability density that was expected, before the measurement, for a
        pose of the base.

        The density includes a small probability that people have moved the base.
        """
        off = np.subtract(planned_T_base, self.planned_T_base)
        off[2] = wrap(float(off[2]))
        moved = _log_normal(off, self.covariance + MOVED_BY)
        return float(np.logaddexp(_log_normal(off, self.covariance), MOVED_LOG_SHARE + moved))


class MarkAssignment(NamedTuple):
    """Assignment of seen landmarks to landmarks of the plan, for one assumed pose of the base, with
    likelihood.
    """

    planned_T_base: Pose2
    marks: tuple[int | None, ...]
    """Index of the mark of the plan for each sighting; None without one."""
    score: float
    """Log-likelihood of the assignment, up to a constant for all explanations of the same sightings."""

    def rivals(self, other: MarkAssignment) -> bool:
        """Return True if the base pose of another assignment differs from this one's by more than 20 mm or
        0.05 rad.
        """
        one, two = self.planned_T_base, other.planned_T_base
        return one.distance(two) > APART or one.turn(two) > APART_TURN


def explain(
    marks: Sequence[PlannedMark], seen: Sequence[Sighting], belief: BasePrior, shown: Shown
) -> list[MarkAssignment]:
    """Return all poses of the base from which at least one landmark of the plan is seen, the most likely
    first.

    Each pair of a landmark of the plan and a seen landmark gives a pose of the base. Its likelihood follows
    from the other seen landmarks, the expected but missing ones, and the prior. This is data association by
    joint compatibility (Neira and Tardós, 2001), with Bar-Shalom's costs of missing and false detections.

    Args:
        marks: landmarks of the plan.
        seen: seen landmarks in all pictures together, each once.
        belief: prior of the base's pose.
        shown: function that reports whether a landmark at a pose would have been seen.
    """
    found: dict[tuple[int | None, ...], MarkAssignment] = {}
    for sighting in seen:
        for mark in marks:
            if mark.kind in sighting:
                guess = mark.place.compose(sighting[mark.kind].inverse())
                one = _explained(guess, marks, seen, belief, shown)
                if one.score > found.get(one.marks, one._replace(score=-math.inf)).score:
                    found[one.marks] = one
    return sorted(found.values(), key=lambda assignment: -assignment.score)


def rivals(explanations: Sequence[MarkAssignment]) -> list[MarkAssignment]:
    """Return the most likely assignment of seen marks to landmarks, then its rivals.

    Rivals are assignments whose log-likelihood is less by at most `MIN_LOG_RATIO`, but that mean another pose
    of the base.

    Args:
        explanations: assignments, the most likely first.
    """
    best = explanations[0]
    close = [explanation for explanation in explanations if explanation.score > best.score - MIN_LOG_RATIO]
    return [best, *(assignment for assignment in close if assignment.rivals(best))]


def _explained(
    guess: Pose2, marks: Sequence[PlannedMark], seen: Sequence[Sighting], belief: BasePrior, shown: Shown
) -> MarkAssignment:
    chosen = [_mark_at(guess, marks, sighting) for sighting in seen]
    pairs = [
        (marks[i], sighting[marks[i].kind]) for i, sighting in zip(chosen, seen, strict=True) if i is not None
    ]
    place = _fit(pairs) if pairs else guess
    misfit = sum(0.5 * (place.compose(at).distance(mark.place) / SIGMA) ** 2 for mark, at in pairs)
    missing = _missing(place, [mark for i, mark in enumerate(marks) if i not in chosen], shown)
    stray = chosen.count(None)
    score = belief.log_density(place) - misfit - stray * STRAY_LOG_COST - missing * UNSEEN_LOG_COST
    return MarkAssignment(place, tuple(chosen), score)


def _mark_at(planned_T_base: Pose2, marks: Sequence[PlannedMark], seen: Sighting) -> int | None:
    """Return the index of the plan's mark at a sighting from a base pose. Marks of a plan don't
    overlap.
    """
    for i, mark in enumerate(marks):
        if mark.kind in seen:
            at = planned_T_base.compose(seen[mark.kind])
            if at.distance(mark.place) < NEAR and at.turn(mark.place) < NEAR_TURN:
                return i
    return None


def _missing(planned_T_base: Pose2, marks: Sequence[PlannedMark], shown: Shown) -> int:
    """Return the number of some marks that should be visible from a base pose."""
    to_base, count = planned_T_base.inverse(), 0
    for kind in {mark.kind: None for mark in marks}:
        places = [to_base.compose(mark.place) for mark in marks if mark.kind == kind]
        count += int(np.count_nonzero(shown(kind, places)))
    return count


def _fit(pairs: Sequence[tuple[PlannedMark, Pose2]]) -> Pose2:
    """Return planned_T_base that brings the seen marks nearest to the plan: Procrustes, with headings.

    `pairs` are marks of the plan and the base_T_mark at which they were seen.
    """
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


def _log_normal(off: FloatArray, covariance: FloatArray) -> float:
    size = float(off @ np.linalg.solve(covariance, off))
    return -0.5 * (size + float(np.linalg.slogdet(covariance)[1]))
