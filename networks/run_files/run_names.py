"""Names of the folders of runs, the newest of them, and a short description of each."""

from __future__ import annotations

import os
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import orjson

from .run_folder import JOURNAL_FILE, NoRun, read_file

LATEST_LINK = "latest"
"""Name of the link next to the runs to the one that was begun last."""
SUMMARY_FILE = "summary.json"
REPORT_FILE = "report.html"
OVERVIEW_FILE = "overview.svg"
FILES_OF_AN_END = (SUMMARY_FILE, REPORT_FILE, OVERVIEW_FILE)
"""Files of a run's folder that say how the run ended."""
GENERIC_STEM = "task"
"""Stem of a task's file that is less specific than its folder's name."""
_HEADER = 16 * 2**20  # of a journal, in [bytes]: a header holds its task's network


@dataclass(frozen=True)
class ListedRun:
    """Row of a list of runs, with the task, begin and outcome of one run."""

    folder: Path
    task: str
    """Path of the task's file, as given when it was run."""
    seed: int
    backend: str
    outcome: str
    """Outcome; empty if the run has no end yet, or never got one."""
    begun: float
    """Time of its begin, in [s] since 1970."""


def name_of(task: Path, seed: int) -> str:
    """Return the name of a run: `FILE-SEED`, or `FOLDER-SEED` for a file called `task.yaml`."""
    path = task.resolve()
    return f"{path.parent.name if path.stem == GENERIC_STEM else path.stem}-{seed}"


def point_latest(folder: Path) -> None:
    """Make the link `latest`, next to a run's folder, point to this folder, in one atomic step.

    On systems without symbolic links nothing is made.
    """
    link = folder.with_name(LATEST_LINK)
    new = folder.with_name(f".{LATEST_LINK}.{os.getpid()}.new")
    with suppress(OSError):
        os.symlink(folder.name, new)
        try:
            os.replace(new, link)
        except OSError:
            new.unlink()


def latest_run(runs: Path) -> Path:
    """Return the folder of the run that was begun last; raises `NoRun` if it is not known."""
    try:
        name = os.readlink(runs / LATEST_LINK)
    except OSError:
        raise NoRun(runs / LATEST_LINK, "no run is known to be the latest") from None
    if Path(name).name != name:
        raise NoRun(runs / LATEST_LINK, "it leads out of its folder")
    return runs / name


def list_runs(runs: Path) -> list[ListedRun]:
    """Return the runs in a folder, the newest first; entries that are no runs are skipped."""
    if not runs.is_dir():
        return []
    found = (_listed(path) for path in runs.iterdir() if path.is_dir() and not path.is_symlink())
    return sorted((item for item in found if item), key=lambda item: (-item.begun, item.folder.name))


def _listed(folder: Path) -> ListedRun | None:
    try:
        with (folder / JOURNAL_FILE).open("rb") as stream:
            header = orjson.loads(stream.readline(_HEADER))
        summary = read_file(folder, SUMMARY_FILE, _HEADER, missing=True)
        outcome = orjson.loads(summary)["outcome"] if summary else ""
        begun = float(header["wall"]["unix_s"])
        return ListedRun(
            folder, str(header["task_path"]), int(header["seed"]), str(header["backend"]), str(outcome), begun
        )
    except (OSError, NoRun, LookupError, TypeError, ValueError):
        return None
