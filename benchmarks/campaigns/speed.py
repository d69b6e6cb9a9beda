"""What a campaign costs beside its trials: time and memory.

    python -m benchmarks.campaigns.speed [--trials 100000]

The network alone, as a command, start included; trials of 50 ms on two workers against the ideal; the
memory of many trials and their report. One of 50 ms sleeps, so that two need no second core.
"""

from __future__ import annotations

import argparse
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from benchmarks.campaigns.walk import walk
from handcart.evaluation.campaigns.trial import Trial
from handcart.evaluation.campaigns.trial_log import TrialLog
from handcart.evaluation.campaigns.workers import Workers

SLEEPS_S, SLEEPERS = 0.05, 1000


def sleep(seed: int) -> Trial:
    """A trial that takes 50 ms."""
    time.sleep(SLEEPS_S)
    return Trial(seed, 0, {"outcome": "Success", "reason": "", "seed": seed, "metrics": {}})


def overhead(folder: Path) -> tuple[float, float]:
    """By how much longer than ideal a campaign takes on two workers: in all, and from the first trial on."""
    began = time.monotonic()
    first, ended = 0.0, 0
    with TrialLog(folder / "trials.jsonl") as log:
        for together in Workers(sleep, 2).trials(range(SLEEPERS)):
            log.append(together)
            ended += len(together)
            if not first:
                first, before = time.monotonic(), ended
    end = time.monotonic()
    ideal = SLEEPERS * SLEEPS_S / 2
    rest = (SLEEPERS - before) * SLEEPS_S / 2
    return (end - began) / ideal - 1.0, (end - first) / rest - 1.0


def campaign(task: Path, trials: int, out: Path, jobs: int) -> float:
    """Seconds of wall time for a campaign of the network alone, as a command."""
    words = ["campaign", str(task), "--level", "network", "--trials", str(trials), "--jobs", str(jobs)]
    began = time.monotonic()
    subprocess.run(
        [sys.executable, "-m", "handcart", *words, "--out", str(out)],
        check=True,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    return time.monotonic() - began


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--trials", type=int, default=100_000)
    trials = parser.parse_args().trials
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        task = walk(folder)
        least = min(campaign(task, 1000, folder / f"small{number}", 1) for number in range(3))
        nothing = min(campaign(task, 1, folder / f"one{number}", 1) for number in range(3))
        print(f"1000 trials, network alone: {least:.2f} s, of which {nothing:.2f} s for a campaign of one")
        taken = campaign(task, trials, folder / "big", 1)
        peak = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024.0
        print(f"{trials} trials, network alone: {taken:.1f} s, at most {peak:.0f} MiB")
        whole, running = overhead(folder)
        print(f"{SLEEPERS} trials of 50 ms on 2 workers: {100 * whole:.2f} % more than ideal, start included")
        print(f"  {100 * running:.2f} % once the first has ended")


if __name__ == "__main__":
    main()
