"""Compare rare ends by multilevel splitting with the exact value: bias, coverage, and cost.

    python -m benchmarks.campaigns.rare [--estimates 1000] [--runs 20]

Walks: `--estimates` independent estimates, each of 20 populations of 100, in three networks: GiveUp after
Fails alone; no action left to try; and a part of the GiveUps at once, which no level can help with. Runs
on the kinematic backend: one estimate of `--runs` populations of 50.
"""

from __future__ import annotations

import argparse
import math
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.progress import track

from benchmarks.campaigns.tosses import TOSS_PRIMITIVE, rare_walk, tosses
from handcart.evaluation.campaigns.data.trial import Trial
from handcart.evaluation.campaigns.data.walked_trials import WalkedTrials, network_trials
from handcart.evaluation.campaigns.rare.rare_estimate import RareEstimate
from handcart.evaluation.campaigns.rare.rare_event import RareEvent
from handcart.evaluation.campaigns.rare.rare_trial import run_population, walked_population
from handcart.evaluation.campaigns.statistics.exact_value import exact_end
from handcart.evaluation.campaigns.statistics.intervals import wilson
from handcart.networks.coordination.interrupts import Interrupts
from handcart.networks.runs.run_options import RunOptions
from handcart.primitives import registry

POPULATIONS, LIKELY = 20, 0.1


def estimates(trials: WalkedTrials, event: RareEvent, count: int) -> list[RareEstimate]:
    """Independent ones."""
    console = Console(stderr=True)
    return [
        RareEstimate.of(
            walked_population(trials, event, seed)
            for seed in range(number * POPULATIONS, (number + 1) * POPULATIONS)
        )
        for number in track(range(count), "estimates", console=console)
    ]


def report_walks(words: str, path: Path, event: RareEvent, count: int) -> bool:
    """Print what estimates of walks are worth; whether their mean is the exact value, within 4 sigma."""
    exact = exact_end(path, {}, event.outcome)
    assert isinstance(exact, float)
    began = time.process_time()
    found = estimates(network_trials(path, {}), event, count)
    took = time.process_time() - began
    values = np.array([estimate.probability for estimate in found])
    mean, sigma = float(values.mean()), float(values.std(ddof=1))
    off = (mean - exact) / (sigma / math.sqrt(count))
    inside = sum(estimate.agrees(exact) for estimate in found)
    wide = sum(
        estimate.low is not None and estimate.low <= exact <= estimate.high + estimate.unseen
        for estimate in found
        if estimate.high is not None
    )
    low, high = wilson(inside, count)
    cost = sum(estimate.cost for estimate in found) / count
    print(f"{words} ({event.importance}): exact {exact:.4g}, mean of {count} estimates {mean:.4g}")
    print(f"  {off:+.1f} sigma off; one estimate is off by {100 * sigma / exact:.0f} %")
    print(f"  intervals that hold it: {100 * inside / count:.1f} % ({100 * low:.1f} to {100 * high:.1f});")
    print(f"  with what could be unseen {100 * wide / count:.1f} %")
    worth = exact * (1.0 - exact) / sigma**2
    print(f"  an estimate costs as much as {cost:,.0f} plain walks and shows as much as {worth:,.0f}:")
    print(f"  {worth / cost:.0f} times; {1e3 * took / count:.0f} ms of CPU", flush=True)
    return abs(off) < 4.0


def report_runs(folder: Path, count: int) -> None:
    """Print an estimate of runs, beside the exact value."""
    known = registry._all()
    known |= TOSS_PRIMITIVE
    path, event, began = tosses(folder), RareEvent.of("GiveUp", "fails", 50), time.process_time()
    with Interrupts() as heard:
        options = RunOptions(settings={"likely": str(LIKELY)}, interrupts=heard)
        trials: Sequence[Trial] = [
            run_population(path, folder / "runs", options, event, seed)
            for seed in track(range(count), "populations", console=Console(stderr=True))
        ]
    found = RareEstimate.of(trials)
    print(f"runs on the kinematic backend: exact {LIKELY**4:.4g}, {found.probability:.4g} from {count}")
    print(f"  populations of 50, interval {found.low} to {found.high};")
    print(f"  actions of {found.cost:,.0f} plain runs, worth {found.worth:,.0f};")
    print(f"  {time.process_time() - began:.0f} s of CPU")


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--estimates", type=int, default=1000)
    parser.add_argument("--runs", type=int, default=20)
    chosen = parser.parse_args()
    right = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for words, outcome, importance, at_once in (
            ("GiveUp after three Fails", "GiveUp", "fails", 0.0),
            ("nothing left to try", "Fail", "fails", 0.0),
            ("nothing left to try", "Fail", "attempts", 0.0),
            ("GiveUp, a tenth of them at once", "GiveUp", "fails", 1e-5),
        ):
            event = RareEvent.of(outcome, importance, 100)
            right.append(report_walks(words, rare_walk(folder, at_once), event, chosen.estimates))
        if chosen.runs:
            report_runs(folder, chosen.runs)
    sys.exit(0 if all(right) else 1)


if __name__ == "__main__":
    main()
