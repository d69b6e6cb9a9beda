"""Kill the parent or a worker of campaigns at random instants, and count lost and doubled trials.

    python -m benchmarks.campaigns.kills [--kills 200] [--trials 60000] [--seed 0]

Each campaign is continued with the same command until it ends; then its report must equal that of an
undisturbed campaign, byte for byte.
"""

from __future__ import annotations

import argparse
import json
import random
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

from rich.console import Console
from rich.progress import Progress

from benchmarks.campaigns.walk import walk

QUIET_STREAMS = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}


def command(task: Path, out: Path, trials: int) -> list[str]:
    """Return the campaign's, always the same."""
    words = ["campaign", str(task), "--level", "network", "--trials", str(trials), "--jobs", "2"]
    return [sys.executable, "-m", "handcart", *words, "--out", str(out), "--json"]


def children(process: int) -> list[int]:
    """Return the process IDs of a process's children."""
    try:
        found = Path(f"/proc/{process}/task/{process}/children").read_text(encoding="utf-8")
    except OSError:
        return []
    return [int(part) for part in found.split()]


def disturbed(words: list[str], chance: random.Random, most: int, lasts: float) -> Counter[str]:
    """Run a campaign, killing what runs at random instants, until it has had so many kills, or is over.

    Undisturbed it lasts so long, in [s].
    """
    kills: Counter[str] = Counter()
    while sum(kills.values()) < most:
        process = subprocess.Popen(words, **QUIET_STREAMS)  # type: ignore[call-overload]
        wait = chance.uniform(0.0, 1.2 * lasts)
        while True:
            time.sleep(wait)
            wait = chance.uniform(0.0, 0.2 * lasts)
            if process.poll() is not None:
                return kills
            workers = children(process.pid)
            kill_worker = bool(workers) and chance.random() < 0.8 and sum(kills.values()) < most - 1
            if kill_worker:
                subprocess.run(["kill", "-9", str(chance.choice(workers))], check=False, **QUIET_STREAMS)  # type: ignore[call-overload]
                kills["worker"] += 1
            else:
                process.kill()
                process.wait()
                kills["parent"] += 1
                break
    return kills


def main() -> None:
    """Kill, check and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--kills", type=int, default=200)
    parser.add_argument("--trials", type=int, default=60000)
    parser.add_argument("--seed", type=int, default=0)
    chosen = parser.parse_args()
    chance, kills, campaigns = random.Random(chosen.seed), Counter[str](), 0
    lost = double = unequal = 0
    with tempfile.TemporaryDirectory() as name, Progress(console=Console(stderr=True)) as progress:
        folder = Path(name)
        task = walk(folder)
        began = time.monotonic()
        whole = subprocess.check_output(
            command(task, folder / "whole", chosen.trials), stderr=subprocess.DEVNULL
        )
        lasts = time.monotonic() - began
        shown = progress.add_task("kills", total=chosen.kills)
        while kills.total() < chosen.kills:
            campaigns += 1
            words = command(task, folder / f"out{campaigns}", chosen.trials)
            kills += disturbed(words, chance, chosen.kills - kills.total(), lasts)
            report = subprocess.check_output(words, stderr=subprocess.DEVNULL)
            lines = (folder / f"out{campaigns}" / "trials.jsonl").read_bytes().splitlines()
            seeds = Counter(json.loads(line)["seed"] for line in lines)
            lost += sum(seed not in seeds for seed in range(chosen.trials))
            double += sum(times - 1 for times in seeds.values())
            unequal += report != whole
            progress.update(shown, completed=kills.total())
            if not progress.console.is_terminal:
                found = f"{lost} lost, {double} double, {unequal} unequal"
                print(
                    f"{kills.total()} of {chosen.kills} kills, {campaigns} campaigns: {found}",
                    file=sys.stderr,
                )
    print(f"{kills['parent']} parents and {kills['worker']} workers killed in {campaigns} campaigns of")
    print(f"{chosen.trials} trials: {lost} lost, {double} double, {unequal} reports that aren't equal")
    sys.exit(1 if lost or double or unequal else 0)


if __name__ == "__main__":
    main()
