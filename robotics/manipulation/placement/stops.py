"""Stops of the base, from each of which the hand serves some of its goals."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import product
from typing import NamedTuple

import numpy as np

from handcart.robotics.manipulation.arms.placement_scores import PlacementScores
from handcart.robotics.manipulation.paths.tool_path import ToolPath
from handcart.robotics.manipulation.paths.untrackable import Untrackable
from handcart.robotics.numerics.arrays import BoolArray, FloatArray

from .placement_division import best_division_by_cost
from .placer import Blocked, Placer

Sight = Callable[[float], ToolPath]
"""Function that returns the motion of the hand, in the world, in which its camera sees a landmark.

Its argument is the heading of the base in the world, in [rad].
"""
Touches = Callable[[FloatArray, int], str]
"""Function that names the obstacle touched from a base pose (3,) at a goal of given index; empty if none.

The base pose is map_T_base: x, y in [m], heading in [rad].
"""

STOP_OFFSET_M = 0.05  # [m] by which a base stops beside its place
STOP_TURN_RAD = 0.05  # [rad]
_ASIDE = (
    (STOP_OFFSET_M, STOP_OFFSET_M, STOP_TURN_RAD),
    (-STOP_OFFSET_M, STOP_OFFSET_M, -STOP_TURN_RAD),
    (-STOP_OFFSET_M, -STOP_OFFSET_M, STOP_TURN_RAD),
    (STOP_OFFSET_M, -STOP_OFFSET_M, -STOP_TURN_RAD),
)
_ATTEMPTS = 40
_HALVINGS = 2
_NEAR = 0.05  # [m] around a stop from which a goal was not possible
_NOWHERE = "is out of the arm's reach, wherever the base stands"
_NO_ROOM = "is reached only from where the base can't stand, or doesn't get to"
_NO_SIGHT = "is reached only from where no landmark can be looked at"


class Goal(NamedTuple):
    """Task of the hand at one place: the motion to make there, and other motions that must be possible
    too.
    """

    work: ToolPath
    """Motion of the hand at the goal, along which a stop is scored."""
    looks: tuple[ToolPath, ...] = ()
    """Further motions that the hand must reach, such as views of its camera; they are not scored."""


class BaseStop(NamedTuple):
    """A pose of the base from which the hand does its tasks at consecutive goals, `first` to `last`."""

    base: FloatArray
    """(3,) map_T_base, x and y in [m], heading in [rad]."""
    first: int
    last: int
    """Last goal that is served; `first` and `last` are both included."""
    sights: tuple[int, ...]
    """Indices of the landmarks that can be looked at from the stop."""
    scores: FloatArray
    """Least score along the motion at each goal, (last - first + 1,), from 0 to 1."""


class StopTable(NamedTuple):
    """Scores of b base poses for n goals of the hand, and which of m landmarks can be seen from each base
    pose.
    """

    values: FloatArray
    """Scores (b, n); 0 where a goal is not served."""
    served: BoolArray
    """Mask (b, n) of goals whose motions are all reached, also from poses slightly off the stop."""
    sights: BoolArray
    """Mask (b, m) of the landmarks that can be looked at."""

    @property
    def usable(self) -> BoolArray:
        """Return a mask (b, n), True where the arm reaches all motions of a goal from a base pose, and a
        landmark is visible.
        """
        sighted = np.asarray(self.sights.any(axis=1))
        return np.asarray(self.served & sighted[:, None])


class StopPlacer:
    """Planner of base poses, called stops, from which the arm does its tasks at given goals, in their order.

    At each stop the arm does the tasks of one or several successive goals.

    Hatano et al. (2000), section 3, do not state how to choose the pose of the base for a goal. Here the
    value of a stop is the directional manipulability (Shin 2005) along the hand's motions at its goals, and
    each additional stop has to improve the total value by `cost`. From each stop a landmark must be visible.
    The goals must also be reached from poses slightly off the stop.
    """

    def __init__(self, placer: Placer, sights: Sequence[Sight]) -> None:
        self._placer, self._sights = placer, sights

    def table(self, bases: FloatArray, goals: Sequence[Goal]) -> StopTable:
        """Return for each base pose its scores for goals, the goals whose motions the arm reaches from there,
        and the visible landmarks.

        A base pose from which no landmark is visible has score 0, and counts as reaching no goal.

        Args:
            bases: (b, 3) map_T_base: x, y in [m], heading in [rad].
            goals: n goals, each with the motions that the arm must reach.
        """
        values = np.zeros((len(bases), len(goals)))
        served = np.zeros((len(bases), len(goals)), dtype=np.bool_)
        sights = self._in_sight(bases)
        some = np.flatnonzero(sights.any(axis=1))
        if len(some):
            for number, goal in enumerate(goals):
                values[some, number], served[some, number] = self._worth(bases[some], goal)
        return StopTable(values, served, sights)

    def _worth(self, bases: FloatArray, goal: Goal) -> tuple[FloatArray, BoolArray]:
        """Return (b,) the least score along a goal's motion, 0 where it isn't served; and whether it is."""
        scores = self._placer.scores(bases, goal.work)
        good: BoolArray = np.asarray(scores.usable.all(axis=1))
        for path in (goal.work, *goal.looks):
            good = self._also_beside(bases, path, good)
        return np.where(good, scores.values.min(axis=1), 0.0), good

    def place(
        self, goals: Sequence[Goal], blocked: Blocked, touches: Touches | None = None, cost: float = 0.3
    ) -> tuple[BaseStop, ...]:
        """Return the stops of the base from which the hand reaches its goals with the best total score.

        Args:
            goals: goals of the hand, in the order in which they are reached.
            blocked: function that reports which of many base poses are blocked.
            touches: function that reports contacts of the robot at a chosen stop and goal; None: no check.
            cost: increase of the total score that justifies one more stop, without unit.

        Raises:
            Untrackable: a goal can't be reached from any base pose; `index` is the goal's number.
        """
        around = _joined(goals)
        candidates = self._placer.candidates(around)
        bases = candidates[~blocked(candidates)]
        table, refused = self.table(bases, goals), list[tuple[FloatArray, int, str]]()
        for _ in range(_ATTEMPTS):
            usable = _without(table.usable, bases, refused)
            if not usable.any(axis=0).all():
                raise self._explained(int(np.argmin(usable.any(axis=0))), goals, bases, candidates, refused)
            stops = self._refined(_stops(bases, table, usable, cost), goals, blocked, refused)
            bad = [
                (stop.base, goal, why)
                for stop in stops
                for goal in range(stop.first, stop.last + 1)
                if touches is not None and (why := touches(stop.base, goal))
            ]
            if not bad:
                return stops
            refused += bad
        raise Untrackable(bad[0][1], f"{bad[0][2]}; so it was with {_ATTEMPTS} divisions")

    def _also_beside(self, bases: FloatArray, path: ToolPath, good: BoolArray) -> BoolArray:
        """Return True for `good` base poses (b, 3) from whose neighbourhood the complete path is reached as
        well.
        """
        good = good.copy()
        for aside in ((0.0, 0.0, 0.0), *_ASIDE):
            some = np.flatnonzero(good)
            if not len(some):
                break
            good[some] = self._placer.reached(bases[some] + aside, path).all(axis=1)
        return good

    def _in_sight(self, bases: FloatArray) -> BoolArray:
        """(b, m): which landmarks can be looked at."""
        seen = np.zeros((len(bases), len(self._sights)), dtype=np.bool_)
        for heading in np.unique(bases[:, 2]):
            some = np.flatnonzero(bases[:, 2] == heading)
            for number, sight in enumerate(self._sights):
                good = np.ones(len(some), dtype=np.bool_)
                seen[some, number] = self._also_beside(bases[some], sight(float(heading)), good)
        return seen

    def _refined(
        self,
        stops: tuple[BaseStop, ...],
        goals: Sequence[Goal],
        blocked: Blocked,
        refused: Sequence[tuple[FloatArray, int, str]],
    ) -> tuple[BaseStop, ...]:
        """Return as many stops, each moved to a better score."""
        step, turn = self._placer.spacing
        for _ in range(_HALVINGS):
            step, turn = step / 2, turn / 2
            moved = []
            for stop in stops:
                ways = np.array(list(product((0.0, -1.0, 1.0), repeat=3))) * (step, step, turn)
                tried = stop.base + ways
                tried = tried[~blocked(tried)]
                own = goals[stop.first : stop.last + 1]
                table = self.table(tried, own)
                refused_here = [(base, goal - stop.first, why) for base, goal, why in refused]
                whole = _without(table.usable, tried, refused_here).all(axis=1)
                worth = np.where(whole, table.values.sum(axis=1), -1.0)
                best = int(np.argmax(worth)) if len(tried) else -1
                better = best >= 0 and worth[best] >= stop.scores.sum()
                moved.append(_stop(tried, table, best, stop.first, stop.last, stop.first) if better else stop)
            stops = tuple(moved)
        return stops

    def _explained(
        self,
        goal: int,
        goals: Sequence[Goal],
        bases: FloatArray,
        candidates: FloatArray,
        refused: Sequence[tuple[FloatArray, int, str]],
    ) -> Untrackable:
        touched = [why for _, number, why in refused if number == goal]
        if touched:
            return Untrackable(goal, touched[0])
        if not self._worth(candidates, goals[goal])[1].any():
            return Untrackable(goal, _NOWHERE)
        if not len(bases) or not self._worth(bases, goals[goal])[1].any():
            return Untrackable(goal, _NO_ROOM)
        return Untrackable(goal, _NO_SIGHT)


def _stops(bases: FloatArray, table: StopTable, usable: BoolArray, cost: float) -> tuple[BaseStop, ...]:
    """Return the best division of goals: each is a step of a path, between goals there are steps without
    length.
    """
    values, joined = np.where(usable, table.values, 0.0), np.ones((len(bases), 2 * usable.shape[1] - 1), bool)
    joined[:, ::2] = usable
    twice = np.repeat(values, 2, axis=1).astype(np.float32)
    scores = PlacementScores(np.asfortranarray(twice), np.ones_like(twice, dtype=np.bool_), joined)
    lengths = np.concatenate(([0.0], np.cumsum(np.arange(2 * usable.shape[1] - 1) % 2 == 0)))
    division = best_division_by_cost(scores, lengths, cost)
    found = []
    for placement, start, end in division.segments:
        first, last = (start + 1) // 2, (end - 1) // 2
        if first <= last:
            found.append(_stop(bases, table, placement, first, last, 0))
    return tuple(found)


def _stop(bases: FloatArray, table: StopTable, row: int, first: int, last: int, offset: int) -> BaseStop:
    sights = tuple(np.flatnonzero(table.sights[row]).tolist())
    return BaseStop(bases[row], first, last, sights, table.values[row, first - offset : last + 1 - offset])


def _without(
    usable: BoolArray, bases: FloatArray, refused: Sequence[tuple[FloatArray, int, str]]
) -> BoolArray:
    usable = usable.copy()
    for base, goal, _ in refused:
        if 0 <= goal < usable.shape[1]:
            usable[np.linalg.norm(bases - base, axis=1) < _NEAR, goal] = False
    return usable


def _joined(goals: Sequence[Goal]) -> ToolPath:
    """Return the motions at all goals as one path, for a search of base poses around it."""
    works = [goal.work for goal in goals]
    return ToolPath(*(np.concatenate(field) for field in zip(*works, strict=True)))
