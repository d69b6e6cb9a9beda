"""Campaigns: one task, many seeds."""

from __future__ import annotations

import math
import os
import signal
import tempfile
import threading
import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, ProcessPoolExecutor, wait
from dataclasses import dataclass
from itertools import islice
from multiprocessing import active_children, get_context, parent_process
from multiprocessing.connection import wait as wait_for
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import binomtest

from handcart.networks.coordination.interrupts import Interrupts
from handcart.networks.coordination.supervision import INTERRUPTED
from handcart.networks.run_options import RunOptions

from .running import run_task

WorldGenerator = Callable[[int, Path], Mapping[str, str]]
"""Writes the files of a world, by a seed, into a folder, and gives the settings of a task that name them."""


@dataclass(frozen=True)
class CampaignSetting:
    """What all trials of a campaign have in common."""

    task: Path
    backend: str | None = None
    settings: Mapping[str, str] | None = None
    world: WorldGenerator | None = None
    """What makes each trial a world of its own, by its seed; None: the task's own."""
    runs: Path = Path("runs")


@dataclass(frozen=True)
class Trial:
    """One run of a campaign."""

    seed: int
    status: int
    summary: Mapping[str, Any]
    signalled: bool = False
    """Whether an interrupt came, be it after its last action."""

    @property
    def success(self) -> bool:
        """Whether the goal was reached."""
        return self.status == 0

    @property
    def cancelled(self) -> bool:
        """Whether somebody stopped it: then it says nothing of the task."""
        return bool(self.summary["outcome"] == "Cancelled")

    @property
    def interrupted(self) -> bool:
        """Whether a signal stopped it, or came as it was over; it stops all that the trial is part of."""
        return self.signalled or (self.cancelled and self.summary["reason"] == INTERRUPTED)

    @property
    def untrue(self) -> Sequence[str]:
        """What the ground truth contradicts."""
        return list(self.summary["metrics"].get("untrue", []))


def run_trial(setting: CampaignSetting, seed: int) -> Trial:
    """One seeded run, in a world of its own where the setting says so."""
    chosen = dict(setting.settings or {})
    if setting.world is None:
        return _run(setting, setting.task, chosen, seed)
    with tempfile.TemporaryDirectory() as folder:
        named = setting.world(seed, Path(folder))
        return _run(setting, setting.task, {**named, **chosen}, seed)


def _run(setting: CampaignSetting, task: Path, settings: Mapping[str, str], seed: int) -> Trial:
    with Interrupts() as heard:
        summary, status = run_task(
            task, setting.runs, RunOptions(setting.backend, settings, seed, interrupts=heard)
        )
    return Trial(seed, status, summary, heard.came)


def run_campaign(setting: CampaignSetting, seeds: Sequence[int], jobs: int) -> Iterator[Trial]:
    """Run the trials in a pool of processes; each is handed out when it has ended.

    A trial that was cancelled by itself is left out. An interrupt (Ctrl-C, SIGTERM, SIGHUP) stops the trials
    that run, and ends the campaign.

    Raises:
        KeyboardInterrupt: there was one.
    """
    with Interrupts():
        every = _one_by_one(setting, seeds) if jobs == 1 else _side_by_side(setting, seeds, jobs)
        for trial in every:
            if not trial.cancelled:
                yield trial
            if trial.interrupted:
                raise KeyboardInterrupt


def _one_by_one(setting: CampaignSetting, seeds: Sequence[int]) -> Iterator[Trial]:
    for seed in seeds:
        yield run_trial(setting, seed)


def _side_by_side(setting: CampaignSetting, seeds: Sequence[int], jobs: int) -> Iterator[Trial]:
    others = set(active_children())
    with ProcessPoolExecutor(jobs, get_context("spawn"), _begin) as pool:
        left = iter(seeds)
        running = {pool.submit(run_trial, setting, seed) for seed in islice(left, jobs)}
        try:
            while running:
                done, running = wait(running, return_when=FIRST_COMPLETED)
                running |= {pool.submit(run_trial, setting, seed) for seed in islice(left, len(done))}
                for each in done:
                    yield each.result()
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            _end(set(active_children()) - others)
            raise


def _end(processes: Iterable[BaseProcess]) -> None:
    """Tell them to end until they have: one whose trial was just over takes up another that waits."""
    while alive := [each for each in processes if each.is_alive()]:
        for process in alive:
            process.terminate()
        wait_for([each.sentinel for each in alive], timeout=0.5)


def _begin() -> None:
    """In each of the pool's processes: it computes beside others, and ends when it is ended or left alone."""
    import cv2

    cv2.setNumThreads(1)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # it comes to all of a terminal's processes; one is enough
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = parent_process()
    assert parent is not None
    parent.join()
    while True:
        os.kill(os.getpid(), signal.SIGTERM)
        time.sleep(1.0)


@dataclass(frozen=True)
class Spread:
    """How a metric is distributed over the trials that have it."""

    count: int
    least: float
    median: float
    most_95: float
    """95 % of the trials are at or below this."""
    most: float


@dataclass(frozen=True)
class CampaignReport:
    """What came out of a campaign."""

    trials: tuple[Trial, ...]

    @property
    def successes(self) -> int:
        """Trials that reached the goal."""
        return sum(trial.success for trial in self.trials)

    @property
    def wilson(self) -> tuple[float, float]:
        """95 % interval of the success rate, by Wilson; of no trials at all it is everything."""
        if not self.trials:
            return 0.0, 1.0
        interval = binomtest(self.successes, len(self.trials)).proportion_ci(method="wilson")
        return float(interval.low), float(interval.high)

    @property
    def outcomes(self) -> Counter[str]:
        """How often each outcome, with the reason where it isn't Success."""
        return Counter(
            trial.summary["outcome"] + (f": {trial.summary['reason']}" if trial.summary["reason"] else "")
            for trial in self.trials
        )

    @property
    def untrue(self) -> list[Trial]:
        """Trials with an outcome that the ground truth contradicts."""
        return [trial for trial in self.trials if trial.untrue]

    def spreads(self) -> dict[str, Spread]:
        """Each metric's distribution; of yes and no, the share of yes."""
        metrics: dict[str, list[float]] = {}
        for trial in self.trials:
            figures = dict(trial.summary["metrics"])
            figures |= {key: trial.summary[key] for key in ("sim_time_s", "wall_time_s", "actions", "fails")}
            for name, value in figures.items():
                if isinstance(value, bool | int | float) and math.isfinite(value):
                    metrics.setdefault(name, []).append(float(value))
        return {name: _spread(values) for name, values in metrics.items()}

    def worst(self, most: int = 5) -> list[Trial]:
        """Trials to look at first: untrue ones, then those that did not succeed, then those with Fails."""
        ranked = sorted(
            self.trials, key=lambda each: (not each.untrue, each.success, -each.summary["fails"], each.seed)
        )
        return [each for each in ranked if each.untrue or not each.success or each.summary["fails"]][:most]


def _spread(values: Sequence[float]) -> Spread:
    least, median, most_95, most = np.quantile(values, [0.0, 0.5, 0.95, 1.0])
    return Spread(len(values), float(least), float(median), float(most_95), float(most))
