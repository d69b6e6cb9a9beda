"""Where a robot was, told after the drive: the smoother of Rauch, Tung and Striebel (1965)."""

from __future__ import annotations

from typing import NamedTuple

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


class _Stretch(NamedTuple):
    """From one entry of the record to the next."""

    begin: Belief
    transition: Array
    end: Belief
    """As forecast, before anything was seen there."""


class TrackRecord:
    """Takes down a Kalman filter's run, correction by correction, and smooths it.

    Steps between two corrections are put together: a record grows with what was seen, not with the periods.
    """

    def __init__(self) -> None:
        """Nothing taken down yet."""
        self._runs: list[list[_Stretch]] = []
        self._marks: list[tuple[int, int]] = []
        self._latest = Belief(np.zeros(0), np.zeros((0, 0)))
        self._transition = np.zeros((0, 0))

    def start(self, mean: Array, covariance: Array) -> None:
        """The filter begins, or begins anew: nothing is carried back from here on."""
        self._runs.append([])
        self._begin(mean, covariance)

    def step(self, transition: Array) -> None:
        """The filter went on by `transition` (n, n)."""
        self._transition = transition @ self._transition

    def correct(self, forecast: Belief, mean: Array, covariance: Array) -> None:
        """The filter saw something: its `forecast`, and mean (n,) and covariance (n, n) afterwards."""
        self._runs[-1].append(_Stretch(self._latest, self._transition, forecast))
        self._begin(mean, covariance)

    def mark(self, now: Belief) -> None:
        """This moment is wanted."""
        self.correct(now, now.mean, now.covariance)
        self._marks.append((len(self._runs) - 1, len(self._runs[-1])))

    @property
    def entries(self) -> tuple[int, int, int]:
        """How much is taken down: beginnings, corrections since the last, marks."""
        return len(self._runs), len(self._runs[-1]), len(self._marks)

    def rewind(self, entries: tuple[int, int, int], now: Belief) -> None:
        """Forget what was corrected after `entries`, in the same run; the filter held `now` then."""
        if entries[0] != len(self._runs):
            raise ValueError("a record can't be rewound to before the filter began anew")
        del self._runs[-1][entries[1] + 1 :]  # what led up to the correction stays
        del self._marks[entries[2] :]
        self._begin(*now)

    def smoothed(self) -> list[Belief]:
        """The marked moments, by all that was seen before and after them."""
        runs = [
            _smooth(run, self._latest if run is self._runs[-1] else run[-1].end) for run in self._runs if run
        ]
        numbers = [k for k, run in enumerate(self._runs) if run]
        return [runs[numbers.index(run)][place] for run, place in self._marks]

    def _begin(self, mean: Array, covariance: Array) -> None:
        self._latest = Belief(mean.copy(), covariance.copy())
        self._transition = np.eye(len(mean))


def _smooth(run: list[_Stretch], last: Belief) -> list[Belief]:
    """Beliefs at the begin of each stretch and at the end of the last."""
    out = [last]
    for stretch in reversed(run):
        scale = np.sqrt(np.maximum(np.diag(stretch.end.covariance), LEAST**2))
        unit = stretch.end.covariance / np.outer(scale, scale) + LEAST * np.eye(len(scale))
        reach = stretch.transition @ stretch.begin.covariance / scale[:, None]
        gain = np.linalg.solve(unit, reach).T / scale
        mean = stretch.begin.mean + gain @ (out[-1].mean - stretch.end.mean)
        spread = stretch.begin.covariance + gain @ (out[-1].covariance - stretch.end.covariance) @ gain.T
        out.append(Belief(mean, 0.5 * (spread + spread.T)))
    return out[::-1]
