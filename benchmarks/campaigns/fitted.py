"""Test whether three quarters of a campaign predict the last quarter, with injected faults.

    python -m benchmarks.campaigns.fitted [FOLDER] [--trials 240] [--tasks return_book ...]

Runs each task on the kinematic backend with `faults.yaml`, in subfolders of FOLDER that the same command
continues; learns from the first seeds, and prints for the last quarter the share of Successes with its 95
% interval (Wilson), the mean time with its own (Student), and the predictions of both. Then 10^6 walks
with parameters learned from all trials, and as many through a network with probabilities, beside the exact
value.
"""

from __future__ import annotations

import argparse
import math
import tempfile
import time
from pathlib import Path

import numpy as np
from scipy.stats import t as student

import handcart
from benchmarks.campaigns.walk import walk
from handcart.evaluation.campaigns.data.walked_trials import WalkedTrials, network_trials
from handcart.evaluation.campaigns.learned.learned_odds import LearnedOdds
from handcart.evaluation.campaigns.learned.prediction import predict
from handcart.evaluation.campaigns.learned.seen_actions import SeenActions
from handcart.evaluation.campaigns.statistics.exact_value import exact_goal
from handcart.evaluation.campaigns.statistics.intervals import wilson
from handcart.evaluation.campaigns.statistics.walk_tally import WalkTally
from handcart.networks.task.task_file import load_task

REPOSITORY_ROOT = Path(__file__).parents[2]
TASK_NAMES = ("stack_blocks", "track_seam", "return_book", "deploy_straight")
FAULTS_FILE = Path(__file__).with_name("faults.yaml")
WALK_COUNT = 1_000_000


def main() -> None:
    """Run, learn, compare."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("folder", nargs="?", type=Path)
    parser.add_argument("--trials", type=int, default=240)
    parser.add_argument("--tasks", nargs="+", choices=TASK_NAMES, default=TASK_NAMES)
    chosen = parser.parse_args()
    with tempfile.TemporaryDirectory() as made:
        for name in chosen.tasks:
            compare(name, (chosen.folder or Path(made)) / name, chosen.trials)
        exact_and_many(Path(made))


def compare(name: str, folder: Path, trials: int) -> None:
    """One task."""
    path = REPOSITORY_ROOT / "tasks" / name / "task.yaml"
    report = handcart.campaign(path, trials=trials, faults=FAULTS_FILE, out=folder, report=False)
    task = load_task(path)
    seen = SeenActions.of(task, report.trials)
    numbers = np.arange(len(seen.success))
    learned = len(numbers) * 3 // 4
    first, second = seen.chosen(numbers[:learned]), seen.chosen(numbers[learned:])
    found, count = predict(task, first), len(second.success)
    low, high = wilson(int(second.success.sum()), count)
    mean = float(second.time_s.mean())
    half = float(student.ppf(0.975, count - 1) * second.time_s.std(ddof=1) / math.sqrt(count))
    inside = low <= found.success <= high, abs(found.time_s - mean) <= half
    print(
        f"{name:<16} P(goal) predicted {found.success:.3f}, in {count} others {second.success.mean():.3f} "
        f"({low:.3f} to {high:.3f}); mean time {found.time_s:.1f} s, {mean:.1f} ({mean - half:.1f} to "
        f"{mean + half:.1f}): {' and '.join('inside' if item else 'OUTSIDE' for item in inside)}",
        flush=True,
    )
    share_walked("walks as learned", WalkedTrials(task, LearnedOdds(task, seen)))


def share_walked(words: str, trials: WalkedTrials) -> float:
    """Walk many times; gives the share of Successes."""
    began, cpu = time.monotonic(), time.process_time()
    tally = WalkTally(trials, range(WALK_COUNT))
    count = sum(tally.count_all())
    share = tally.successes / count
    took, used = time.monotonic() - began, time.process_time() - cpu
    print(f"{'':<16} {count} {words}: {share:.5f}, {took:.1f} s, {used:.1f} of CPU", flush=True)
    return share


def exact_and_many(folder: Path) -> None:
    """Compare exact and sampled values of the network alone."""
    path = walk(folder)
    share, exact = share_walked("walks through a network", network_trials(path, {})), exact_goal(path, {})
    assert isinstance(exact, float)
    sigma = math.sqrt(exact * (1.0 - exact) / WALK_COUNT)
    print(f"{'':<16} exact {exact:.5f}: {(share - exact) / sigma:+.1f} sigma off")


if __name__ == "__main__":
    main()
