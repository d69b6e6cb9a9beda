"""Compare the runs of two versions: python -m benchmarks.same_runs CHECKOUT --kept FOLDER [--seeds 5]

Each shipped task is run by the other checkout's code and by this one's, each with its own task files, on
one backend. Compared are outcomes, actions, simulated times, false outcomes, contacts, metrics, and the
journals, record by record except for wall times and versions. Finished runs in FOLDER are not repeated.

Prints a row for each task. Exit status 1 if an outcome is worse than before: another status than Success,
a false outcome, or an unwanted contact where there was none.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from statistics import median
from typing import Any, NamedTuple

import orjson
from rich.console import Console
from rich.progress import track
from rich.table import Table

REPOSITORY_ROOT = Path(__file__).resolve().parents[1]
OTHER_TASK_FILES = ("tower.yaml", "unload.yaml", "locate.yaml")
VERSION_KEYS = {"wall", "h", "p", "handcart", "task_path", "task_text", "task_sha256", "robot_sha256"}


class Pair(NamedTuple):
    """Folders of the same task's runs with the same seed, by the other checkout and by this one."""

    task: Path
    seed: int
    before: Path
    now: Path


class Comparison(NamedTuple):
    """Differences between two runs."""

    pair: Pair
    outcomes: tuple[str, str]
    actions: tuple[list[str], list[str]]
    times_s: tuple[float, float]
    false_outcomes: tuple[int, int]
    contacts: tuple[int, int]
    first_difference: str  # empty where journals and metrics are equal

    @property
    def worse(self) -> bool:
        """True if this version's run has a worse end."""
        lost = self.outcomes[0] == "Success" != self.outcomes[1]
        return lost or self.false_outcomes[1] > self.false_outcomes[0] or self.contacts[1] > self.contacts[0]


def task_files(checkout: Path, only: list[str]) -> list[Path]:
    """Return the paths of the shipped task files, relative to the checkout."""
    found = [
        path.relative_to(checkout)
        for path in sorted((checkout / "tasks").glob("*/*.yaml"))
        if path.name in ("task.yaml", *OTHER_TASK_FILES)
    ]
    return [path for path in found if not only or path.parent.name in only]


def finished_run(checkout: Path, task: Path, seed: int, backend: str, folder: Path) -> Path:
    """Return the folder of a task's run by a checkout's code; run it where it is not there yet.

    Raises:
        RuntimeError: it ended without a summary.
    """
    runs = folder / backend / f"{task.parent.name}-{task.stem}-{seed}"
    if not list(runs.glob("*-*/summary.json")):
        words = ["run", str(task), "--seed", str(seed), "--backend", backend, "--runs", str(runs)]
        ended = subprocess.run(
            [sys.executable, "-c", "from handcart.tools.main import main; main()", *words],
            cwd=checkout,
            env={**os.environ, "PYTHONPATH": str(checkout / "src"), "OMP_NUM_THREADS": "1"},
            capture_output=True,
            text=True,
            check=False,
        )
        if not list(runs.glob("*-*/summary.json")):
            raise RuntimeError(f"{checkout}: {task}, seed {seed}: {ended.stderr[-2000:]}")
    return next(runs.glob("*-*/summary.json")).parent


def without_versions(value: Any) -> Any:
    """Return a value without what differs between two runs of one seed, and between two versions."""
    if isinstance(value, dict):
        return {key: without_versions(part) for key, part in value.items() if key not in VERSION_KEYS}
    return [without_versions(part) for part in value] if isinstance(value, list) else value


def journal_records(run: Path) -> list[dict[str, Any]]:
    """Return a journal's compared records, without the world model's entries that an action uses."""
    lines = (run / "journal.jsonl").read_bytes().splitlines()
    records = [without_versions(orjson.loads(line)) for line in lines]
    for action in records[0]["plan_on"]["actions"]:
        action.pop()
    return records


def actions(records: list[dict[str, Any]]) -> list[str]:
    """Return the actions of a run in their order, without their number in the network."""
    started = [record["action"] for record in records if record.get("kind") == "START"]
    return [" ".join(str(action.get(key)) for key in ("do", "from", "to")) for action in started]


def first_difference(records: list[list[dict[str, Any]]], metrics: list[dict[str, Any]]) -> str:
    """Return the first difference of two runs in words; empty if they are alike."""
    for before, after in zip(*records, strict=False):
        if before != after:
            keys = [key for key in before.keys() | after.keys() if before.get(key) != after.get(key)]
            return f"record {before.get('q')} ({before.get('kind')}) differs in {', '.join(sorted(keys))}"
    if len(records[0]) != len(records[1]):
        return f"{len(records[0])} records before, {len(records[1])} now"
    keys = [
        key for key in metrics[0].keys() | metrics[1].keys() if metrics[0].get(key) != metrics[1].get(key)
    ]
    return f"metrics differ: {', '.join(sorted(keys))}" if keys else ""


def compared(pair: Pair) -> Comparison:
    """Compare two finished runs."""
    records = [journal_records(run) for run in (pair.before, pair.now)]
    summaries = [orjson.loads((run / "summary.json").read_bytes()) for run in (pair.before, pair.now)]
    metrics = [summary["metrics"] for summary in summaries]
    return Comparison(
        pair,
        (summaries[0]["outcome"], summaries[1]["outcome"]),
        (actions(records[0]), actions(records[1])),
        (summaries[0]["sim_time_s"], summaries[1]["sim_time_s"]),
        (_count(metrics[0], "untrue"), _count(metrics[1], "untrue")),
        (_count(metrics[0], "contacts_unmeant"), _count(metrics[1], "contacts_unmeant")),
        first_difference(records, metrics),
    )


def _count(metrics: dict[str, Any], key: str) -> int:
    value = metrics.get(key, 0)
    return len(value) if isinstance(value, list) else int(value)


def task_row(comparisons: list[Comparison]) -> tuple[str, ...]:
    """Return the table's row of one task."""

    def both(numbers: list[tuple[Any, Any]], wanted: Any) -> str:
        return " / ".join(str(sum(pair[side] == wanted for pair in numbers)) for side in (0, 1))

    return (
        str(comparisons[0].pair.task.relative_to("tasks")),
        str(len(comparisons)),
        both([run.outcomes for run in comparisons], "Success"),
        str(sum(run.outcomes[0] == run.outcomes[1] for run in comparisons)),
        str(sum(run.actions[0] == run.actions[1] for run in comparisons)),
        str(sum(not run.first_difference for run in comparisons)),
        f"{median(run.times_s[1] / max(run.times_s[0], 1e-9) for run in comparisons):.3f}",
        " / ".join(str(sum(run.false_outcomes[side] for run in comparisons)) for side in (0, 1)),
        " / ".join(str(sum(run.contacts[side] for run in comparisons)) for side in (0, 1)),
    )


def print_table(comparisons: list[Comparison], backend: str) -> None:
    """Print a row for each task, and a line for each run that ended worse."""
    table = Table(title=f"before / now, {backend}")
    for name in ("task", "runs", "Success", "same outcome", "same actions", "same journal"):
        table.add_column(name)
    for name in ("time now / before", "false outcomes", "unwanted contacts"):
        table.add_column(name)
    for task in dict.fromkeys(run.pair.task for run in comparisons):
        table.add_row(*task_row([run for run in comparisons if run.pair.task == task]))
    Console(width=150).print(table)
    for run in comparisons:
        if run.worse:
            print(
                f"worse: {run.pair.task}, seed {run.pair.seed}: {' -> '.join(run.outcomes)} ({run.pair.now})"
            )


def main() -> int:
    """Run, compare, and print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("before", type=Path, help="a checkout of the other version")
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--backend", default="kinematic")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--kept", type=Path, required=True, help="folder for the runs")
    parser.add_argument("--only", nargs="*", default=[], help="folders of tasks")
    wanted = parser.parse_args()
    before, kept = wanted.before.resolve(), wanted.kept.resolve()
    others = set(task_files(before, wanted.only))
    version = subprocess.run(
        ["git", "rev-parse", "HEAD"], cwd=REPOSITORY_ROOT, capture_output=True, text=True, check=False
    )
    now = kept / f"now-{version.stdout.strip()[:8] or 'here'}"

    def pair_of(task: Path, seed: int) -> Pair:
        sides = ((before, kept / "before"), (REPOSITORY_ROOT, now))
        return Pair(task, seed, *(finished_run(side, task, seed, wanted.backend, to) for side, to in sides))

    both = [task for task in task_files(REPOSITORY_ROOT, wanted.only) if task in others]
    with ThreadPoolExecutor(wanted.jobs) as threads:
        pending = [threads.submit(pair_of, task, seed) for task in both for seed in range(wanted.seeds)]
        comparisons = [compared(future.result()) for future in track(pending, "runs")]
    print_table(comparisons, wanted.backend)
    return int(any(run.worse for run in comparisons))


if __name__ == "__main__":
    sys.exit(main())
