"""Kill return_book at random instants and resume it: `python -m benchmarks.hostile.crashes [NUMBER [SEED]]`.

Each run is killed (SIGKILL) at an instant drawn from a run's whole duration, and resumed; if it was over
by then, another instant is drawn from the duration it had. Counted are: outcomes of the journal that are
lost, finished actions that are done again, and ends that differ from those of an undisturbed run (outcome,
situation, simulated time).
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
from contextlib import suppress
from pathlib import Path
from typing import Any

from handcart.networks.journal.journal_record import read_journal

TASK_FILE = Path(__file__).resolve().parents[2] / "tasks" / "return_book" / "task.yaml"
REPOSITORY_ROOT = TASK_FILE.parents[2]


def command(*words: object) -> list[str]:
    """Return a command line of handcart in this Python."""
    return [sys.executable, "-m", "handcart", *map(str, words)]


def run_and_kill(runs: Path, seconds: float) -> tuple[Path, float]:
    """Return the folder of a run, killed so long after it listened to its operator, and how long it lived."""
    process = subprocess.Popen(
        command("run", TASK_FILE, "--runs", runs),
        cwd=REPOSITORY_ROOT,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    folder = runs / "return_book-0"
    while not (folder / "control").exists() and process.poll() is None:
        time.sleep(0.005)
    begun = time.monotonic()
    with suppress(subprocess.TimeoutExpired):
        process.wait(seconds)
    process.kill()
    process.wait()
    return folder, time.monotonic() - begun


def results(folder: Path) -> list[tuple[int, str]]:
    """Return the action of the network and the outcome of each RESULT in the journal."""
    index: dict[int, int] = {}
    found = []
    for record in read_journal(folder / "journal.jsonl").records:
        if record["kind"] == "START":
            index[record["n"]] = record["action"]["index"]
        elif record["kind"] == "RESULT":
            found.append((index[record["n"]], record["outcome"]))
    return found


def last_json(text: str) -> dict[str, Any]:
    """Return the summary on the last line."""
    summary: dict[str, Any] = json.loads(text.splitlines()[-1])
    return summary


def main() -> None:
    """Print what was lost, repeated, or ended otherwise."""
    words = argparse.ArgumentParser(description=__doc__)
    words.add_argument("number", nargs="?", type=int, default=100)
    words.add_argument("seed", nargs="?", type=int, default=0)
    wanted = words.parse_args()
    trials, rng, count = wanted.number, random.Random(wanted.seed), Counter[str]()
    with tempfile.TemporaryDirectory() as folder:
        said = subprocess.run(
            command("run", TASK_FILE, "--runs", Path(folder) / "whole", "--json"),
            cwd=REPOSITORY_ROOT,
            capture_output=True,
            text=True,
        )
        whole = last_json(said.stdout)
        lasts = whole["wall_time_s"]
        started = 0
        while count["resumed"] < trials:
            run, lived = run_and_kill(Path(folder) / str(started), rng.uniform(0.0, lasts))
            started += 1
            before = results(run)
            said = subprocess.run(
                command("resume", run, "--json"), cwd=REPOSITORY_ROOT, capture_output=True, text=True
            )
            if said.returncode == 2 and "is over" in said.stderr:
                lasts = lived
                continue
            count["resumed"] += 1
            after = results(run)
            count["outcomes lost"] += after[: len(before)] != before
            done = Counter(action for action, outcome in after if outcome == "Success")
            count["actions repeated"] += any(times > 1 for times in done.values())
            if said.returncode != 0:
                count["ended otherwise"] += 1
                print(said.stderr[-400:])
                continue
            end = last_json(said.stdout)
            keys = ("outcome", "situation", "sim_time_s", "fails")
            count["ended otherwise"] += any(end[key] != whole[key] for key in keys)
            print(f"\r{started} runs: {dict(count)}", end="", flush=True)
    print()


if __name__ == "__main__":
    main()
