"""Trials of a campaign as columns for plots and for the list of trials."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

from handcart.evaluation.campaigns.data.trial import Trial
from handcart.evaluation.campaigns.statistics.tally import OF_ALL, figures
from handcart.robotics.numerics.arrays import FloatArray

MOST_ROWS = 10_000
MOST_CELLS = 100_000  # beside those that all trials have
MOST_WORDS = 1_000_000  # letters of all reasons together
MAX_REASON_LETTERS = 160  # letters of a reason


class TrialRow(NamedTuple):
    """Row of a campaign page's table of trials, with seed, outcome, metrics and name of the run."""

    seed: int
    outcome: str
    untrue: bool
    run: str
    """Name of the run's folder; empty without one."""
    cells: tuple[str, ...]
    why: str
    """Reason of an outcome other than Success; empty otherwise."""


class TrialTable:
    """Table of a campaign's trials and their metrics, for the list and the plots of a campaign page."""

    def __init__(self, trials: Iterable[Trial]) -> None:
        """Read all trials, in the order of their seeds."""
        self.seeds: list[int] = []
        self._ends: list[tuple[str, bool, str, str]] = []
        values: dict[str, list[tuple[int, float]]] = {name: [] for name in OF_ALL}
        success: list[bool] = []
        for at, trial in enumerate(trials):
            self.seeds.append(trial.seed)
            success.append(trial.success)
            self._ends.append((trial.summary["outcome"], bool(trial.untrue), trial.run_name, _why(trial)))
            for name, value in {**figures(trial), **trial.varied}.items():
                values.setdefault(name, []).append((at, float(value)))
        self.success = np.array(success, bool)
        """(n,) True for each trial that reached the goal."""
        self.columns = {name: self._column(group) for name, group in values.items()}
        """(n,) values of each metric and of each varied number, by name; NaN for trials without it."""

    def _column(self, found: Iterable[tuple[int, float]]) -> FloatArray:
        column = np.full(len(self.seeds), math.nan)
        for at, value in found:
            column[at] = value
        return column

    def differing(self) -> list[str]:
        """Return the names of the columns whose values differ between trials.

        The columns that every trial has (`OF_ALL`) are listed first, then the others, sorted by name.
        """
        names = [*OF_ALL, *sorted(self.columns.keys() - set(OF_ALL))]
        return [name for name in names if not constant(self.columns[name])]

    def listed(self) -> tuple[list[str], list[TrialRow], int]:
        """Return columns and rows of the page's list of trials, and the number of trials that it omits.

        To keep the page of a large campaign small, it omits the least interesting trials, whose Success the
        ground truth does not contradict, and columns of metrics that not all trials have.
        """
        chosen = self._chosen()
        names = list(OF_ALL)
        names += [name for name in self.differing() if name not in names][: MOST_CELLS // max(1, len(chosen))]
        reasons = sum(bool(self._ends[at][3]) for at in chosen)
        longest = min(MAX_REASON_LETTERS, MOST_WORDS // max(1, reasons))
        rows = [self._row(at, names, longest) for at in chosen]
        return names, rows, len(self.seeds) - len(rows)

    def _chosen(self) -> Sequence[int]:
        """Return the listed trials, ordered by seed; trials without Success and false outcomes are chosen
        first.
        """
        if len(self.seeds) <= MOST_ROWS:
            return range(len(self.seeds))
        dull = [bool(self.success[at]) and not self._ends[at][1] for at in range(len(self.seeds))]
        ordered = sorted(range(len(self.seeds)), key=dull.__getitem__)
        return sorted(ordered[:MOST_ROWS])

    def _row(self, at: int, names: Iterable[str], longest: int) -> TrialRow:
        outcome, untrue, run, why = self._ends[at]
        cells = tuple(short(float(self.columns[name][at])) for name in names)
        shown = why if len(why) <= longest else f"{why[:longest]}…"
        return TrialRow(self.seeds[at], outcome, untrue, run, cells, shown)


def constant(values: FloatArray) -> bool:
    """Return whether all finite values (n,) of a column, in any unit, are equal."""
    there = values[np.isfinite(values)]
    return not len(there) or bool((there == there[0]).all())


def short(value: float) -> str:
    """Return a finite number as text with at most five significant digits; an empty text for others."""
    return f"{value:.5g}" if math.isfinite(value) else ""


def _why(trial: Trial) -> str:
    return "; ".join(trial.untrue) or str(trial.summary["reason"])
