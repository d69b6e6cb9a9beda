"""One population as a trial of a campaign."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from handcart.evaluation.campaigns.data.trial import Trial
from handcart.evaluation.campaigns.data.walked_trials import WalkedTrials
from handcart.networks.runs.run_options import RunOptions

from .population import Population, split
from .rare_event import RareEvent
from .split_runs import SplitRuns
from .walked_runs import WalkedRuns

ESTIMATED_OUTCOME = "Estimated"
"""Outcome of a trial that is a population."""
_WALKED, _RUN = 21, 22  # separate these random streams from others with the same seeds


def walked_population(trials: WalkedTrials, event: RareEvent, seed: int) -> Trial:
    """Estimate a rare event's probability with random walks through the network, by multilevel splitting.

    All walks together are returned as one trial.

    Args:
        trials: network and probabilities of the walks.
        event: the rare event.
        seed: seed of the population.
    """
    draws = np.random.default_rng([_WALKED, seed % 2**64])
    found = split(WalkedRuns(trials.task.network, trials.walker, event, draws), event.runs, draws)
    return _trial(seed, found, {})


def run_population(task: Path, runs: Path, options: RunOptions, event: RareEvent, seed: int) -> Trial:
    """Run a population of runs on a simulated backend by multilevel splitting, and return it as one trial.

    Args:
        task: the task's file.
        runs: folder for the runs' folders; those of some hits are kept.
        options: options of the runs; `interrupts` must be set.
        event: the rare event.
        seed: seed of the population; the runs of its first level have the seeds from `seed * event.runs` to
            `(seed + 1) * event.runs - 1`.

    Raises:
        KeyboardInterrupt: the population was interrupted.
        BrokenRun: a run crashed or was stopped from outside.
        HandcartError: a run cannot be executed.
    """
    draws = np.random.default_rng([_RUN, seed % 2**64])
    runs.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix=f"population-{seed}-", dir=runs) as name:
        split_runs = SplitRuns(task, options, event, seed * event.runs, Path(name), runs)
        found = split(split_runs, event.runs, draws)
    metrics = {"untrue": split_runs.untrue, "runs_kept": split_runs.kept}
    return _trial(seed, found, metrics, split_runs.time_s)


def stopped(seed: int) -> Trial:
    """Return a trial with outcome Cancelled for a population of runs (rare-event estimate) that was
    interrupted.
    """
    from handcart.networks.coordination.supervision import INTERRUPTED_REASON

    summary = {
        "outcome": "Cancelled",
        "reason": INTERRUPTED_REASON,
        "seed": seed,
        "run_dir": "",
        "metrics": {},
    }
    return Trial(seed, 130, summary, signalled=True)


def _trial(seed: int, found: Population, more: Mapping[str, Any], time_s: float = 0.0) -> Trial:
    metrics = {
        "probability": found.probability,
        "levels": [list(level) for level in found.levels],
        "steps_of_a_run": found.steps_of_a_run,
        **more,
    }
    summary = {"outcome": ESTIMATED_OUTCOME, "reason": "", "seed": seed, "run_dir": "", "sim_time_s": time_s}
    summary |= {"actions": found.steps, "fails": 0, "wall_time_s": 0.0, "metrics": metrics}
    return Trial(seed, 0, summary)
