"""Compare the runs of two versions: python -m benchmarks.same_runs CHECKOUT --kept FOLDER [--seeds 5]

Each shipped task is run on the kinematic backend, by the other checkout's code and by this one's, each
with its own task files. Compared are the journals, record by record except for wall times and versions,
and the metrics. The runs of the other checkout are kept in FOLDER, and not repeated. Exit status 1 if two
runs differ.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
from pathlib import Path
from typing import Any

import orjson
from rich.progress import track

REPOSITORY_ROOT = Path(__file__).resolve().parents[1]
OTHER_FILES = ("tower.yaml", "unload.yaml")
TIME_KEYS = {"wall", "h", "p", "handcart", "task_path", "task_text", "task_sha256", "robot_sha256"}


def tasks(checkout: Path, only: list[str]) -> list[Path]:
    """Paths of the shipped task files, from the checkout's top."""
    found = [
        path.relative_to(checkout)
        for path in sorted((checkout / "tasks").glob("*/*.yaml"))
        if path.name in ("task.yaml", *OTHER_FILES)
    ]
    return [path for path in found if not only or path.parent.name in only]


def run(checkout: Path, task: Path, seed: int, folder: Path) -> Path:
    """Run a task by a checkout's code; gives the run's folder, of an earlier call where there is one."""
    runs = folder / f"{task.parent.name}-{task.stem}-{seed}"
    done = list(runs.glob("*-*/summary.json"))
    if not done:
        code = "from handcart.tools.main import main; main()"
        words = ["run", str(task), "--seed", str(seed), "--backend", "kinematic", "--runs", str(runs)]
        said = subprocess.run(
            [sys.executable, "-c", code, *words],
            cwd=checkout,
            env={"PYTHONPATH": str(checkout / "src"), "PATH": ""},
            capture_output=True,
            text=True,
            check=False,
        )
        done = list(runs.glob("*-*/summary.json"))
        if not done:
            raise RuntimeError(f"{checkout}: {task}, seed {seed}: {said.stderr[-2000:]}")
    return done[0].parent


def plain(value: Any) -> Any:
    """Without what differs between two runs of one seed, and between two versions."""
    if isinstance(value, dict):
        return {key: plain(each) for key, each in value.items() if key not in TIME_KEYS}
    return [plain(each) for each in value] if isinstance(value, list) else value


def read(journal: Path) -> list[dict[str, Any]]:
    """Return a journal's compared records, without the world model's entries that an action uses."""
    records = [plain(orjson.loads(line)) for line in journal.read_bytes().splitlines()]
    for action in records[0]["plan_on"]["actions"]:
        action.pop()
    return records


def difference(one: Path, other: Path) -> str:
    """The first one between two runs, in words; empty if they are alike."""
    records = [read(each / "journal.jsonl") for each in (one, other)]
    for before, after in zip(*records, strict=False):
        if before != after:
            keys = [key for key in before.keys() | after.keys() if before.get(key) != after.get(key)]
            return f"record {before.get('q')} ({before.get('kind')}) differs in {', '.join(sorted(keys))}"
    if len(records[0]) != len(records[1]):
        return f"{len(records[0])} records before, {len(records[1])} now"
    metrics = [orjson.loads((each / "summary.json").read_bytes())["metrics"] for each in (one, other)]
    keys = [
        key for key in metrics[0].keys() | metrics[1].keys() if metrics[0].get(key) != metrics[1].get(key)
    ]
    return f"metrics differ: {', '.join(sorted(keys))}" if keys else ""


def main() -> int:
    """Run, compare, and print what differs."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("before", type=Path, help="a checkout of the other version")
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--kept", type=Path, required=True, help="folder for the runs")
    parser.add_argument("--only", nargs="*", default=[], help="folders of tasks")
    wanted = parser.parse_args()
    before, kept = wanted.before.resolve(), wanted.kept.resolve()
    pairs = [(task, seed) for task in tasks(REPOSITORY_ROOT, wanted.only) for seed in range(wanted.seeds)]
    others = set(tasks(before, wanted.only))
    version = subprocess.run(
        ["git", "rev-parse", "HEAD"], cwd=REPOSITORY_ROOT, capture_output=True, text=True, check=False
    )
    now = kept / f"now-{version.stdout.strip()[:8] or 'here'}"
    differ = 0
    for task, seed in track(pairs, "runs"):
        if task not in others:
            print(f"{task}: it isn't there before")
            continue
        wrong = difference(run(before, task, seed, kept / "before"), run(REPOSITORY_ROOT, task, seed, now))
        differ += bool(wrong)
        if wrong:
            print(f"{task}, seed {seed}: {wrong}", flush=True)
    print(f"{len(pairs)} runs, {differ} differ")
    return int(differ > 0)


if __name__ == "__main__":
    sys.exit(main())
