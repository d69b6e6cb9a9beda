"""Where a robot was, told after the drive: the smoother of Rauch, Tung and Striebel (1965)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
LEAST = 1e-9  # of a state's variance before a gain is taken, relative to one: exactly known states have none


class Belief(NamedTuple):
    """What a filter or a smoother holds."""

    mean: Array
    """(n,) states."""
    covariance: Array
    """(n, n)."""


class _Watched(NamedTuple):
    """A moment of which more becomes known while the filter goes on (fixed-point smoothing)."""

    belief: Belief
    """Of the states then, by all that was seen so far."""
    shared: Array
    """(n, n) covariance of the states then (rows) with those now."""


class _Link(NamedTuple):
    """From one wanted moment to the next."""

    first: _Watched
    """As known at the second."""
    second: Belief
    """What the filter held there."""


class Branch(NamedTuple):
    """One way in which the states may have changed just before something was seen."""

    weight: float
    """How likely it is, by what was seen then; all of them are one."""
    transition: Array
    """(n, n), of the change."""
    covariance: Array
    """(n, n) of the states after it."""
    residual: Array
    """(m,) of the readings."""
    mean: Array
    """(n,) of the states once the readings were taken in."""


class Entries(NamedTuple):
    """How much a record holds at one moment."""

    starts: int
    links: int
    latest: _Watched | None


class TrackRecord:
    """Takes down what a Kalman filter's run tells of some wanted moments, and smooths them.

    What is seen between two of them is put together as it comes, so a record grows with the moments that are
    wanted, not with the time.
    """

    STATE: ClassVar = {
        "_over": list[list[Belief]],
        "_links": list[_Link],
        "_latest": _Watched | None,
        "_starts": int,
    }
    """Attributes that change, with their types."""

    def __init__(self) -> None:
        """Nothing taken down yet."""
        self._over: list[list[Belief]] = []  # smoothed, of runs that ended in a new beginning
        self._links: list[_Link] = []
        self._latest: _Watched | None = None
        self._starts = 0

    def start(self) -> None:
        """The filter begins, or begins anew: nothing is carried back from here on."""
        if self._starts:
            self._over.append(self._smoothed())
        self._starts, self._links, self._latest = self._starts + 1, [], None

    def step(self, transition: Array) -> None:
        """The filter went on by `transition` (n, n)."""
        if self._latest is not None:
            self._latest = self._latest._replace(shared=self._latest.shared @ transition.T)

    def correct(self, covariance: Array, rows: Array, residual: Array, variance: float) -> None:
        """The filter is about to see something: readings with `residual` (m,), each of `variance`.

        `rows` (m, n) is how they depend on the states, `covariance` (n, n) that of the states now, without
        them.
        """
        if self._latest is not None:
            self._latest = _after(self._latest, covariance, rows, residual, variance)

    def correct_either(self, branches: Sequence[Branch], rows: Array, variance: float) -> None:
        """The same where the states may have changed before, in one of several ways."""
        latest = self._latest
        if latest is None:
            return
        each = [
            _after(
                latest._replace(shared=latest.shared @ one.transition.T),
                one.covariance,
                rows,
                one.residual,
                variance,
            )
            for one in branches
        ]
        weights = np.array([one.weight for one in branches])
        then = mixed([one.belief for one in each], weights)
        now = weights @ np.array([one.mean for one in branches])
        shared = sum(
            one.weight * (seen.shared + np.outer(seen.belief.mean - then.mean, one.mean - now))
            for one, seen in zip(branches, each, strict=True)
        )
        self._latest = _Watched(then, np.asarray(shared))

    def mark(self, now: Belief) -> None:
        """This moment is wanted."""
        if self._latest is not None:
            self._links.append(_Link(self._latest, now))
        self._latest = _Watched(now, now.covariance)

    @property
    def entries(self) -> Entries:
        """Where the record stands, for `rewind`."""
        return Entries(self._starts, len(self._links), self._latest)

    def rewind(self, entries: Entries) -> None:
        """Forget what came after `entries`, in the same run."""
        if entries.starts != self._starts:
            raise ValueError("a record can't be rewound to before the filter began anew")
        self._links, self._latest = self._links[: entries.links], entries.latest

    def smoothed(self) -> list[Belief]:
        """The wanted moments, by all that was seen before and after them."""
        return [belief for run in (*self._over, self._smoothed()) for belief in run]

    def _smoothed(self) -> list[Belief]:
        if self._latest is None:
            return []
        out = [self._latest.belief]
        for (before, shared), second in reversed(self._links):
            scale = np.sqrt(np.maximum(np.diag(second.covariance), LEAST**2))
            unit = second.covariance / np.outer(scale, scale) + LEAST * np.eye(len(scale))
            gain = np.linalg.solve(unit, (shared / scale).T).T / scale
            mean = before.mean + gain @ (out[-1].mean - second.mean)
            spread = before.covariance + gain @ (out[-1].covariance - second.covariance) @ gain.T
            out.append(Belief(mean, 0.5 * (spread + spread.T)))
        return out[::-1]


def mixed(beliefs: Sequence[Belief], weights: Array) -> Belief:
    """Mean and covariance of one of several beliefs, by how likely each is (k,)."""
    means = np.array([each.mean for each in beliefs])
    mean = weights @ means
    away = means - mean
    within = np.einsum("k,kij->ij", weights, np.array([each.covariance for each in beliefs]))
    return Belief(mean, within + np.einsum("k,ki,kj->ij", weights, away, away))


def _after(watched: _Watched, covariance: Array, rows: Array, residual: Array, variance: float) -> _Watched:
    """What is known of the watched moment once readings were seen; see `TrackRecord.correct`."""
    (mean, spread), shared = watched
    seen = rows @ covariance @ rows.T + variance * np.eye(len(residual))
    gain = np.linalg.solve(seen, rows @ shared.T).T
    spread = spread - gain @ seen @ gain.T
    belief = Belief(mean + gain @ residual, 0.5 * (spread + spread.T))
    return _Watched(belief, shared - gain @ rows @ covariance)
