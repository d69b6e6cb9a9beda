"""Runs on a simulated backend that are stopped at a level and continued from their checkpoints."""

from __future__ import annotations

import shutil
from collections import Counter
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import orjson

from handcart.backends.simulation.noise.split_seed import SplitSeed
from handcart.evaluation.trials.running import resume_task, run_task
from handcart.files.errors import HandcartError
from handcart.networks.runs.run_options import RunOptions
from handcart.robotics.numerics.arrays import IndexArray

from .level_stop import LevelStop, importance_of
from .population import Level
from .rare_event import RareEvent

MAX_KEPT_RUNS = 10
"""Maximum number of hits in a population whose run folders are kept."""


class BrokenRun(HandcartError):
    """Error for a simulated run that crashed or was stopped from outside, which ends the estimate of a rare
    outcome's probability.
    """


class Stopped(NamedTuple):
    """Run that was stopped when it reached a level of importance, so that other runs can continue from its
    state.
    """

    folder: Path
    seed: SplitSeed
    used: Mapping[int, int]
    """Attempts that are used up, by index of the action."""


class SplitRuns:
    """Simulated runs for multilevel splitting, each of which can be stopped at a level and continued from it.

    The levels are steps towards a rare outcome. The runs have folders and checkpoints on disk.
    """

    def __init__(
        self, task: Path, options: RunOptions, event: RareEvent, first: int, folder: Path, runs: Path
    ) -> None:
        """Prepare runs that have not started.

        Args:
            task: the task's file.
            options: options of the runs; `interrupts` must be set.
            event: the rare event.
            first: seed of the first run; the following runs have the next seeds.
            folder: folder for the runs' folders while they are needed.
            runs: folder to which kept run folders are moved.
        """
        assert options.interrupts is not None
        self._task, self._options, self._event, self._heard = task, options, event, options.interrupts
        self._first, self._folder, self._runs = first, folder, runs
        self._stopped: list[Stopped] = []
        self._level = self._count = 0
        self.time_s = 0.0
        """Robot time of all runs together, in [s]."""
        self.untrue: list[str] = []
        """Messages about outcomes that the ground truth contradicts."""
        self.kept: list[str] = []
        """Names of the kept run folders."""

    def advance(self, level: int, starts: IndexArray | int) -> Level:
        """Continue runs until they end or reach a level of importance (nearness to the rare event); keep
        their states there.

        Args:
            level: importance at which the runs are stopped, from 1.
            starts: (n,) index of the state, kept at the previous level, that each run starts from; or the
                number of new runs.

        Raises:
            KeyboardInterrupt: the user ended the estimate.
            BrokenRun: a run ended in an error.
        """
        self._level, before, self._stopped = level, self._stopped, []
        found = Counter[str]()
        count = starts if isinstance(starts, int) else len(starts)
        for number in range(count):
            at = None if isinstance(starts, int) else before[int(starts[number])]
            found += self._one(number, at)
        for item in before:
            shutil.rmtree(item.folder)
        return Level(count, len(self._stopped), found["hits"], found["steps"])

    def _one(self, number: int, at: Stopped | None) -> Counter[str]:
        if at is not None and importance_of(at.used, self._event.importance) >= self._level:
            self._stopped.append(at._replace(folder=self._copied(at.folder)))
            return Counter()
        stop = LevelStop(self._event.importance, self._level, self._heard, {} if at is None else at.used)
        seed, began_s = self._seed(number, at), 0.0
        options = self._seeded(seed, stop)
        if at is None:
            summary, _ = run_task(self._task, self._folder, options)
        else:
            folder = self._copied(at.folder)
            began_s = _time_of(folder)
            summary, _ = resume_task(folder, None, options, seed)
        if self._heard.came:
            raise KeyboardInterrupt
        self.time_s += summary["sim_time_s"] - began_s
        return Counter(steps=stop.steps, hits=self._ended(summary, seed, stop))

    def _ended(self, summary: Mapping[str, Any], seed: SplitSeed, stop: LevelStop) -> bool:
        """Keep a run that stopped at the level, and return whether it ended with the rare outcome."""
        folder = Path(summary["run_dir"])
        if summary["outcome"] == "Cancelled" and stop.near:
            self._stopped.append(Stopped(folder, seed, stop.used))
            return False
        if summary["outcome"] in ("Cancelled", "Error"):
            raise BrokenRun(f"{folder}: a run ended with {summary['outcome']}: {summary['reason']}")
        self.untrue += summary["metrics"].get("untrue", [])
        hit = bool(summary["outcome"] == self._event.outcome)
        if hit and len(self.kept) < MAX_KEPT_RUNS:
            self._keep(folder)
        else:
            shutil.rmtree(folder)
        return hit

    def _keep(self, folder: Path) -> None:
        name = f"rare-{self._first}-{len(self.kept) + 1}"
        shutil.rmtree(self._runs / name, ignore_errors=True)  # left by an interrupted population
        shutil.move(folder, self._runs / name)
        self.kept.append(name)

    def _seed(self, number: int, at: Stopped | None) -> SplitSeed:
        if at is None:
            return SplitSeed(self._first + number)
        return at.seed.split(self._level * self._event.runs + number)

    def _seeded(self, seed: SplitSeed, stop: LevelStop) -> RunOptions:
        observers = (*self._options.observers, stop)
        return replace(self._options, seed=seed, checkpoints=True, observers=observers)

    def _copied(self, folder: Path) -> Path:
        self._count += 1
        copy = self._folder / f"branch-{self._count}"
        shutil.copytree(folder, copy, symlinks=True)
        return copy


def _time_of(folder: Path) -> float:
    return float(orjson.loads((folder / "summary.json").read_bytes())["sim_time_s"])
