"""Small plots of a campaign's page: positions in pixels, which the page's template draws."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from handcart.robotics.numerics.arrays import BoolArray, FloatArray

WIDTH, HEIGHT = 300.0, 96.0
"""Height of a histogram's bars, in [px]."""
MIN_BAR_PX = 1.5  # [px] that a single trial is high at least
_MOST_BINS = 30
_TICKS = 4
_SLACK = 1e-9  # of a step


@dataclass(frozen=True)
class PlotAxis:
    """Horizontal axis of a plot, from its smallest to its largest value, with a width in [px]."""

    least: float
    most: float
    width: float
    whole: bool = False
    """True if only integers are labelled."""

    def at(self, value: float) -> float:
        """Return the position of a value, in [px] from the left."""
        span = self.most - self.least
        return self.width * (value - self.least) / span if span else 0.5 * self.width

    def ticks(self) -> list[tuple[float, str]]:
        """Return the tick labels of the axis, at round values, each as its position in [px] and its text."""
        if self.least == self.most:
            return [(self.at(self.least), f"{self.least:.6g}")]
        least_step = (self.most - self.least) / _TICKS
        decade = 10.0 ** math.floor(math.log10(least_step))
        step = next(
            value * decade for value in (1, 2, 5, 10) if value * decade >= least_step * (1.0 - _SLACK)
        )
        step = max(1.0, step) if self.whole else step
        first = math.ceil(self.least / step - _SLACK)
        last = math.floor(self.most / step + _SLACK)
        return [(self.at(step * index), f"{step * index:.6g}") for index in range(first, last + 1)]


@dataclass(frozen=True)
class Bar:
    """Bar of a histogram: its interval, and the trials with and without Success in it."""

    x: float
    width: float
    reached: float
    """Height of the trials that reached the goal, in [px]."""
    others: float
    """Height of the other trials, on top of `reached`, in [px]."""
    words: str


@dataclass(frozen=True)
class Histogram:
    """Histogram of a metric over trials, as bars with labels for an HTML page."""

    axis: PlotAxis
    bars: Sequence[Bar]
    highest: int
    """Number of trials at full height."""
    median: float
    """Position of the median, in [px]."""
    limit: float | None
    """Position of the largest allowed value, in [px]; None without a limit."""


def histogram(values: FloatArray, success: BoolArray, limit: float | None = None) -> Histogram:
    """Return the histogram of a metric over trials, which shows trials with and without Success separately.

    Args:
        values: (n,) in the metric's unit, at least one of them not NaN.
        success: (n,) True for trials that reached the goal.
        limit: largest allowed value of the metric; None: the metric has no limit.
    """
    there = np.isfinite(values)
    edges = _edges(values[there])
    reached, _ = np.histogram(values[there & success], edges)
    others, _ = np.histogram(values[there & ~success], edges)
    highest = int((reached + others).max())
    least, most = float(edges[0]), float(edges[-1])
    if limit is not None:
        least, most = min(least, limit), max(most, limit)
    axis = PlotAxis(least, most, WIDTH, _are_whole(values[there]))
    scale = HEIGHT / highest
    bars = [
        Bar(
            axis.at(low),
            axis.at(high) - axis.at(low),
            max(scale * yes, MIN_BAR_PX) if yes else 0.0,
            max(scale * no, MIN_BAR_PX) if no else 0.0,
            f"{low:.5g} to {high:.5g}: {yes + no} trials, {no} of them did not reach the goal",
        )
        for low, high, yes, no in zip(edges[:-1], edges[1:], reached, others, strict=True)
    ]
    median = axis.at(float(np.median(values[there])))
    return Histogram(axis, bars, highest, median, None if limit is None else axis.at(limit))


def _edges(values: FloatArray) -> FloatArray:
    least, most = values.min(), values.max()
    if least == most:
        return np.array([least - 0.5, most + 0.5])
    if _are_whole(values) and most - least < _MOST_BINS:
        return np.arange(least - 0.5, most + 1.0)
    count = round(2.0 * len(values) ** (1 / 3))  # Rice's rule
    return np.linspace(least, most, min(_MOST_BINS, max(5, count)) + 1)


def _are_whole(values: FloatArray) -> bool:
    return bool((values == np.round(values)).all())


def share_axis(shares: Sequence[float], width: float) -> PlotAxis:
    """Return an axis in [%] that holds all shares with a margin.

    Args:
        shares: shares from 0 to 1.
        width: length of the axis, in [px].
    """
    least, most = 100.0 * min(shares), 100.0 * max(shares)
    room = max(1.0, 0.15 * (most - least))
    return PlotAxis(max(0.0, least - room), min(100.0, most + room), width)
