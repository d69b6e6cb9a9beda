"""Measure how often `campaign compare` reports a difference, with and without a true one.

    python -m benchmarks.campaigns.comparing [--pairs 1000] [--trials 200]

A pair of campaigns are walks through one action network, with outcomes drawn independently in both, or
with a lower probability of one action in the second. The power is compared with that of the exact McNemar
test.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from rich.console import Console
from rich.progress import track

from benchmarks.campaigns.walk import walk
from handcart.evaluation.campaigns.data.trial import Trial
from handcart.evaluation.campaigns.data.walked_trials import WalkedTrials, network_trials
from handcart.evaluation.campaigns.statistics.comparison import Comparison, compare
from handcart.evaluation.campaigns.statistics.intervals import wilson
from handcart.evaluation.campaigns.statistics.paired_tests import SIGNIFICANCE_LEVEL, mcnemar

LOWER_PROBABILITY = 0.4
"""The first action's probability in the second campaign, where there is a difference."""


def drawn(trials: WalkedTrials, count: int, first: int) -> Sequence[Trial]:
    """Return `count` trials from a seed on, renumbered from 0, so that pairs are independent."""
    return [replace(trials.trial(first + seed), seed=seed) for seed in range(count)]


def shown(words: str, seen: int, count: int) -> str:
    """Return a share with its interval."""
    low, high = wilson(seen, count)
    return f"{words:<58}{seen:>6} of {count} ({100 * low:.1f} to {100 * high:.1f} %)"


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--pairs", type=int, default=1000)
    parser.add_argument("--trials", type=int, default=200)
    chosen = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        same = network_trials(walk(Path(name)), {})
        lower = network_trials(walk(Path(name), LOWER_PROBABILITY), {})
    equal, other = [], []
    for number in track(range(chosen.pairs), "pairs", console=Console(stderr=True)):
        first = 3 * number * chosen.trials
        one = drawn(same, chosen.trials, first)
        equal.append(compare(one, drawn(same, chosen.trials, first + chosen.trials)))
        other.append(compare(one, drawn(lower, chosen.trials, first + 2 * chosen.trials)))
    alarms = sum(any(change.proven for change in found.changes) for found in equal)
    print(f"{chosen.pairs} pairs of campaigns of {chosen.trials} trials")
    print(shown("no difference, any metric called proven", alarms, chosen.pairs))
    print(shown("no difference, e-value ever at 20", sum(_ever(item) for item in equal), chosen.pairs))
    seen, exact = sum(item.success.proven for item in other), sum(_mcnemar(item) for item in other)
    print(shown(f"first action {LOWER_PROBABILITY} for 0.85, success called proven", seen, chosen.pairs))
    print(shown("that, by the exact McNemar test alone", exact, chosen.pairs))
    print(shown("that, e-value ever at 20", sum(_ever(item) for item in other), chosen.pairs))
    loss = 100.0 * (exact - seen) / chosen.pairs
    print(f"power lost for looking at other metrics too: {loss:.1f} points")
    sys.exit(1 if alarms > SIGNIFICANCE_LEVEL * chosen.pairs or loss > 2.0 else 0)


def _ever(found: Comparison) -> bool:
    return found.sure_at is not None


def _mcnemar(found: Comparison) -> bool:
    return mcnemar(found.only_one, found.only_other) <= SIGNIFICANCE_LEVEL


if __name__ == "__main__":
    main()
