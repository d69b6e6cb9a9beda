"""An absorbing Markov chain, by its fundamental matrix."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np


class NeverEnds(Exception):
    """Error, because a Markov chain can run forever without reaching an absorbing state."""


class Absorption(NamedTuple):
    """Probabilities of an absorbing Markov chain's ends, with mean and sigma of its number of steps."""

    ends: dict[str, float]
    """Probability of each absorbing state."""
    steps: float
    """Expected number of steps."""
    steps_sigma: float
    """Standard deviation of the number of steps."""


def absorption(rows: Mapping[str, Mapping[str, float]], start: str) -> Absorption:
    """Return the probabilities of the ends of a Markov chain from `start`, and its number of steps.

    The method is that of Kemeny and Snell, Finite Markov Chains (1960), chapter 3. Q holds the transitions
    among transient states, R those into absorbing ones, and N = (I - Q)^-1. Then the ends are N R, the steps
    t = N 1, and their variance is (2 N - I) t - t².

    Args:
        rows: for each transient state, the probability of each state that follows; a state without a row
            is absorbing.
        start: a transient state.

    Raises:
        NeverEnds: a reachable state cannot reach any absorbing state.
    """
    rows = {
        name: {to: p for to, p in rows[name].items() if p > 0.0 or to not in rows}
        for name in _reached(rows, start)
    }
    if not _end_all(rows):
        raise NeverEnds
    transient = list(rows)
    absorbing = sorted({to for row in rows.values() for to in row} - set(transient))
    place = {name: number for number, name in enumerate([*transient, *absorbing])}
    matrix = np.zeros((len(transient), len(place)))
    for name, row in rows.items():
        for to, p in row.items():
            matrix[place[name], place[to]] += p
    count = len(transient)
    try:
        fundamental = np.linalg.inv(np.eye(count) - matrix[:, :count])
    except np.linalg.LinAlgError:
        raise NeverEnds from None
    ends, steps = fundamental @ matrix[:, count:], fundamental.sum(axis=1)
    variance = (2.0 * fundamental - np.eye(count)) @ steps - steps**2
    at = place[start]
    shares = {name: float(p) for name, p in zip(absorbing, ends[at], strict=True)}
    return Absorption(shares, float(steps[at]), float(np.sqrt(max(0.0, variance[at]))))


def _reached(rows: Mapping[str, Mapping[str, float]], start: str) -> list[str]:
    """Return the transient states that `start` can lead to, in the order of the rows; a transition with
    probability 0 leads nowhere.
    """
    found, new = {start}, [start]
    while new:
        led = {to for name in new for to, p in rows[name].items() if p > 0.0 and to in rows}
        new = list(led - found)
        found.update(new)
    return [name for name in rows if name in found]


def _end_all(rows: Mapping[str, Mapping[str, float]]) -> bool:
    """Return whether each transient state can reach an absorbing one.

    Rounded probabilities that sum to almost 1 give a matrix that can be inverted without any end, so that
    the matrix does not show it.
    """
    ending: set[str] = set()
    while new := {
        name
        for name, row in rows.items()
        if name not in ending and any(p > 0.0 and (to not in rows or to in ending) for to, p in row.items())
    }:
        ending |= new
    return len(ending) == len(rows)
