"""Shipped tasks with injected faults, by their networks with choices and by those of the papers:
`python -m benchmarks.deciding.choices`.

Both get the same seeds, and the same faults at the same instants of the robot's time. A difference is that of
the same seed in both. Its interval is that of Agresti and Min (2005) for P(Success), and that of Student for
the price: the robot's time, and the task's `person_s` for an end short of the goal. A task counts as better
or worse where the interval of either leaves 0 out.
"""

from __future__ import annotations

import argparse
import math
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.stats import norm
from scipy.stats import t as student

from handcart.evaluation.campaigns.campaign import run_campaign
from handcart.evaluation.campaigns.campaign_setting import CampaignSetting
from handcart.evaluation.campaigns.data.trial import Trial

REPOSITORY_ROOT = Path(__file__).parents[2]
FAULTS_FILE = REPOSITORY_ROOT / "benchmarks" / "campaigns" / "faults.yaml"
TASK_NAMES = (
    "track_seam",
    "stack_blocks",
    "return_book",
    "deploy_zigzag",
    "deploy_straight",
    "build_fence",
    "return_books",
    "deploy_field",
)
"""Those with a network of a paper beside their own, the quickest first."""
PERSON_S = 600.0


class Difference(NamedTuple):
    """A difference of two means, with its interval of 95 %."""

    mean: float
    low: float
    high: float

    def words(self, digits: int) -> str:
        """Return it in words."""
        return f"{self.mean:+.{digits}f} ({self.low:+.{digits}f} to {self.high:+.{digits}f})"

    @property
    def sign(self) -> int:
        """1 or -1 if the interval leaves 0 out, otherwise 0."""
        return int(self.low > 0.0) - int(self.high < 0.0)


def share_difference(before: Sequence[bool], after: Sequence[bool]) -> Difference:
    """Return the difference of two shares of the same trials, by Agresti and Min (2005)."""
    pairs = list(zip(before, after, strict=True))
    gained, lost = sum(b > a for a, b in pairs), sum(a > b for a, b in pairs)
    count = len(pairs) + 2.0
    middle, apart = (gained - lost) / count, gained + lost + 1.0
    half = float(norm.ppf(0.975)) * math.sqrt(apart - (gained - lost) ** 2 / count) / count
    return Difference((gained - lost) / len(pairs), middle - half, middle + half)


def mean_difference(before: Sequence[float], after: Sequence[float]) -> Difference:
    """Return the difference of two means of the same trials, by Student."""
    apart = np.subtract(after, before)
    mean = float(apart.mean())
    if len(apart) < 2:
        return Difference(mean, -math.inf, math.inf)
    half = float(student.ppf(0.975, len(apart) - 1) * apart.std(ddof=1) / math.sqrt(len(apart)))
    return Difference(mean, mean - half, mean + half)


def verdict(share: Difference, price: Difference) -> str:
    """Return whether the network with choices is better or worse."""
    signs = share.sign, -price.sign
    if max(signs) > 0 > min(signs):
        return "better and worse"
    return "better" if max(signs) > 0 else "worse" if min(signs) < 0 else "not different for sure"


def run_all(name: str, file: str, seeds: range, faults: Path, folder: Path, jobs: int) -> list[Trial]:
    """Run one network of a task."""
    task, runs = REPOSITORY_ROOT / "tasks" / name / file, folder / name / file.removesuffix(".yaml")
    setting = CampaignSetting(task, runs=runs, faults=faults)
    found: dict[int, Trial] = {}
    for trial in run_campaign(setting, seeds, jobs):
        found[trial.seed] = trial
        outcome, time_s = trial.summary["outcome"], trial.summary["sim_time_s"]
        why = f": {trial.summary['reason'][:110]}" if outcome != "Success" else ""
        print(f"  {file} seed {trial.seed}: {outcome} after {time_s:.0f} s{why}", flush=True)
    return [found[seed] for seed in sorted(found)]


def compare(name: str, before: Sequence[Trial], after: Sequence[Trial]) -> str:
    """Print one task's line, and return its verdict."""
    done = [[trial.success for trial in trials] for trials in (before, after)]
    prices = [[_price(trial) for trial in trials] for trials in (before, after)]
    share, price = share_difference(done[0], done[1]), mean_difference(prices[0], prices[1])
    found = verdict(share, price)
    untrue = sum(bool(item.summary["metrics"].get("untrue")) for item in (*before, *after))
    print(f"{name}: {found} ({len(before)} seeds each; runs with false outcomes: {untrue})")
    for words, trials in (("paper", before), ("choices", after)):
        times = [trial.summary["sim_time_s"] for trial in trials if trial.success]
        mean = f"{np.mean(times):.1f} s" if times else "-"
        count = len(times)
        print(f"  {words:<8} P(Success) {count / len(trials):.3f} ({count}), mean time of Successes {mean}")
    print(f"  P(Success) {share.words(3)}, price {price.words(1)} s", flush=True)
    return found


def _price(trial: Trial) -> float:
    return float(trial.summary["sim_time_s"]) + (0.0 if trial.success else PERSON_S)


def main() -> None:
    """Run both networks of each task, and print a table."""
    words = argparse.ArgumentParser(prog="python -m benchmarks.deciding.choices", description=__doc__)
    words.add_argument("--tasks", nargs="+", choices=TASK_NAMES, default=TASK_NAMES)
    words.add_argument("--seeds", type=int, default=200, help="number of seeds of each task")
    words.add_argument("--first", type=int, default=0, help="first seed")
    words.add_argument("--faults", type=Path, default=FAULTS_FILE, help="file of faults")
    words.add_argument("--jobs", type=int, default=1)
    given = words.parse_args()
    seeds, verdicts = range(given.first, given.first + given.seeds), list[str]()
    with tempfile.TemporaryDirectory() as folder:
        for name in given.tasks:
            print(f"{name}: {given.seeds} seeds, faults by {given.faults.name} ...", flush=True)
            both = [
                run_all(name, file, seeds, given.faults, Path(folder), given.jobs)
                for file in ("paper.yaml", "task.yaml")
            ]
            verdicts.append(compare(name, *both))
    better, worse = verdicts.count("better"), sum("worse" in item for item in verdicts)
    print(f"better in {better} of {len(verdicts)} tasks, worse in {worse}")


if __name__ == "__main__":
    main()
