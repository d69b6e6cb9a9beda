"""Poses of a robot computed after the drive: the smoother of Rauch, Tung and Striebel (1965)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar, NamedTuple

import numpy as np

from handcart.robotics.navigation.odometry.watched_moment import Belief, BeliefBranch, WatchedMoment
from handcart.robotics.numerics.arrays import FloatArray

# of a state's variance before a gain is taken, relative to one: exactly known states have none
MIN_RELATIVE_VARIANCE = 1e-9


class _Link(NamedTuple):
    """Connection of one marked moment to the next."""

    first: WatchedMoment
    """The first moment, as known at the second."""
    second: Belief
    """The filter's belief at the second moment."""


class Entries(NamedTuple):
    """Size that the record of a Kalman filter's run (`TrackRecord`) has at one moment, to rewind the record
    to that moment.
    """

    starts: int
    links: int
    latest: WatchedMoment | None


class TrackRecord:
    """Record of a Kalman filter's run, from which its states at moments that the caller marked are smoothed
    afterwards.

    Readings between two marked moments are combined when they come, so the record grows with the number of
    marked moments, not with time.
    """

    STATE: ClassVar = {
        "_over": list[list[Belief]],
        "_links": list[_Link],
        "_latest": WatchedMoment | None,
        "_starts": int,
    }
    """Attributes that change, with their types."""

    def __init__(self) -> None:
        """Start with an empty record."""
        self._over: list[list[Belief]] = []  # smoothed, of runs that ended in a new beginning
        self._links: list[_Link] = []
        self._latest: WatchedMoment | None = None
        self._starts = 0

    def start(self) -> None:
        """Record that the filter starts or restarts.

        Readings after a restart do not change the smoothed states of earlier moments.
        """
        if self._starts:
            self._over.append(self._smoothed())
        self._starts, self._links, self._latest = self._starts + 1, [], None

    def step(self, transition: FloatArray) -> None:
        """Record that the filter predicted its n states, in SI units, with `transition` (n, n)."""
        if self._latest is not None:
            self._latest = self._latest.stepped(transition)

    def correct(
        self, covariance: FloatArray, rows: FloatArray, residual: FloatArray, variance: float
    ) -> None:
        """Record readings that the filter is about to use.

        Args:
            covariance: (n, n) of the present states before the readings, in SI units.
            rows: (m, n) derivative of the readings by the states.
            residual: (m,) readings less their forecast, in their unit.
            variance: variance of each reading, in its unit squared.
        """
        if self._latest is not None:
            self._latest = self._latest.corrected(covariance, rows, residual, variance)

    def correct_either(self, branches: Sequence[BeliefBranch], rows: FloatArray, variance: float) -> None:
        """Record a filter update by readings before which the states may have changed in one of several ways.

        Args:
            branches: possible changes, each with its weight, transition, residual and covariance.
            rows: (m, n) derivative of the readings by the states.
            variance: variance of each reading, in its unit squared.
        """
        if self._latest is not None:
            self._latest = self._latest.corrected_either(branches, rows, variance)

    def mark(self, now: Belief) -> None:
        """Mark the present moment as one for which `smoothed` returns a belief.

        Args:
            now: the filter's present belief.
        """
        if self._latest is not None:
            self._links.append(_Link(self._latest, now))
        self._latest = WatchedMoment.of(now)

    @property
    def entries(self) -> Entries:
        """Present size of the record, to which `rewind` can later reset it."""
        return Entries(self._starts, len(self._links), self._latest)

    def rewind(self, entries: Entries) -> None:
        """Reset the record to the size that it had at an earlier moment, given by `entries`.

        Raises:
            ValueError: the filter has restarted since that moment.
        """
        if entries.starts != self._starts:
            raise ValueError("a record can't be rewound to before the filter's restart")
        self._links, self._latest = self._links[: entries.links], entries.latest

    def smoothed(self) -> list[Belief]:
        """Return the beliefs at all marked moments, in order, each estimated from the readings before and
        after it.
        """
        return [belief for run in (*self._over, self._smoothed()) for belief in run]

    def _smoothed(self) -> list[Belief]:
        if self._latest is None:
            return []
        out = [self._latest.belief]
        for (before, shared), second in reversed(self._links):
            scale = np.sqrt(np.maximum(np.diag(second.covariance), MIN_RELATIVE_VARIANCE**2))
            unit = second.covariance / np.outer(scale, scale) + MIN_RELATIVE_VARIANCE * np.eye(len(scale))
            gain = np.linalg.solve(unit, (shared / scale).T).T / scale
            mean = before.mean + gain @ (out[-1].mean - second.mean)
            spread = before.covariance + gain @ (out[-1].covariance - second.covariance) @ gain.T
            out.append(Belief(mean, 0.5 * (spread + spread.T)))
        return out[::-1]
