"""Attack run folders: python -m benchmarks.hostile.hostile_folders [--folders 10000] [--seed 0] [--of NAME]

Real runs are made and stopped at several instants, at their ends and after GiveUps; copies of their
folders are damaged by accident (bits, cuts, swaps, losses) or made to do harm (pickles, links, pipes, huge
files, forged journals and checkpoints with right checksums), and read by every reader of run folders.
Counted are: code that ran, changes outside the folder, tracebacks, hangs, and runs that were put back into
another state than they were left in. Exit status 1 if there is one.
"""

from __future__ import annotations

import argparse
import json
import select
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from benchmarks.damage.folder_trial import Trials
from benchmarks.damage.originals import RUN_RECIPES, Original, make, true_state

TASKS_FOLDER = Path(__file__).resolve().parents[2] / "tasks"
MAX_FOLDER_WALL_S = 120.0  # [s] on the wall that one folder gets
FOLDERS_PER_PROCESS = 2000  # folders for one process


def worker(first: int, last: int, seed: int, originals: Path, work: Path) -> None:
    """Attack folders `first` to `last`, a line of JSON for each."""
    known = [
        Original(**{**load, "folder": Path(load["folder"])}) for load in json.loads(originals.read_text())
    ]
    out = sys.stdout
    sys.stdout = sys.stderr
    trials = Trials(known, work, seed)
    for number in range(first, last):
        print(json.dumps(asdict(trials.run(number))), file=out, flush=True)


def originals(names: Sequence[str], where: Path) -> list[Original]:
    """Return runs of these recipes, each with the true state of its folder."""
    found = []
    for recipe in RUN_RECIPES:
        if recipe.name not in names:
            continue
        began = time.monotonic()
        found += [replace(item, state=true_state(item, where)) for item in make(recipe, TASKS_FOLDER, where)]
        print(f"{recipe.name}: {len(found)} folders so far, {time.monotonic() - began:.0f} s", flush=True)
    return found


def verdicts(count: int, seed: int, known: Path, scratch: Path) -> Iterator[dict[str, Any]]:
    """One after the other; a process that hangs or dies is found, and followed by another."""
    number = 0
    while number < count:
        last = min(count, number + FOLDERS_PER_PROCESS)
        with tempfile.TemporaryDirectory(dir=scratch) as work:
            words = [
                sys.executable,
                "-m",
                "benchmarks.hostile.hostile_folders",
                "--worker",
                number,
                last,
                seed,
                known,
                work,
            ]
            with (scratch / "stderr").open("ab") as errors:
                process = subprocess.Popen(
                    [str(word) for word in words], stdout=subprocess.PIPE, stderr=errors
                )
            assert process.stdout is not None
            try:
                while number < last:
                    ready, _, _ = select.select([process.stdout], [], [], MAX_FOLDER_WALL_S)
                    line = process.stdout.readline() if ready else b""
                    if not line:
                        why = f"the process died with {process.wait()}" if ready else "it hangs"
                        yield {"number": number, "attack": "?", "original": "?", "ended": "", "wrong": [why]}
                        number += 1
                        break
                    yield json.loads(line)
                    number += 1
            finally:
                process.kill()
                process.wait()


def main() -> None:
    """Print progress, each violation, and a table in the end."""
    if sys.argv[1:2] == ["--worker"]:
        first, last, seed = map(int, sys.argv[2:5])
        worker(first, last, seed, Path(sys.argv[5]), Path(sys.argv[6]))
        return
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--folders", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument(
        "--of", nargs="*", default=[recipe.name for recipe in RUN_RECIPES], help="names of recipes"
    )
    given = parser.parse_args()
    attacks, ends, wrong = Counter[str](), Counter[tuple[str, str]](), 0
    with tempfile.TemporaryDirectory() as scratch:
        known = Path(scratch) / "originals.json"
        made = originals(given.of, Path(scratch) / "originals")
        known.write_text(
            json.dumps([{**asdict(original), "folder": str(original.folder)} for original in made])
        )
        for done, verdict in enumerate(verdicts(given.folders, given.seed, known, Path(scratch)), start=1):
            attacks[verdict["attack"]] += 1
            ends[verdict["attack"], verdict["ended"]] += 1
            if verdict["wrong"]:
                wrong += 1
                print(
                    f"\n{verdict['number']} {verdict['attack']} on {verdict['original']}: {verdict['wrong']}",
                    flush=True,
                )
            if done % 50 == 0:
                print(f"\r{done} of {given.folders}, {wrong} violations", end="", flush=True)
    print(f"\r{given.folders} folders, {wrong} violations")
    for attack, count in attacks.most_common():
        how = ", ".join(f"{end} {n}" for (a, end), n in ends.most_common() if a == attack)
        print(f"{attack:18} {count:5}  {how}")
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
