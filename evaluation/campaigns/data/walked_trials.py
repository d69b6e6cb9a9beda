"""Trials that are walks through the action network alone, without a robot."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any, overload

import numpy as np

from handcart.evaluation.campaigns.walks.file_odds import FileOdds
from handcart.evaluation.campaigns.walks.odds import EndCode, Odds
from handcart.evaluation.campaigns.walks.walk_table import WalkTable
from handcart.evaluation.campaigns.walks.walker import NO_ACTION, Walked, Walker
from handcart.networks.graph.planner import NoWay
from handcart.networks.graph.route import RunDecisions
from handcart.networks.task.task_file import Task, load_task
from handcart.primitives.outcomes.outcome import Success

from .action_ends import names_in_network
from .trial import ActionEnd, Trial

DRAWN, UNKNOWN = "drawn by its probability", "nobody has seen how it ends"
WALK_BATCH_SIZE = 4096
"""Number of walks that are drawn together. The walk of a seed depends on it, but not on which seeds are asked
for.
"""
_STREAM = 20  # separates these draws from others with the same seed


class WalkedTrials:
    """Reproducible trials of one task as random walks through its network of actions, without a robot.

    Each action's end is drawn by its odds, the probabilities of its outcomes.
    """

    def __init__(self, task: Task, odds: Odds, side_by_side: int = WALK_BATCH_SIZE) -> None:
        """Prepare without walking.

        Args:
            task: task with the network to walk through.
            odds: probabilities of the actions' ends.
            side_by_side: number of seeds whose walks are drawn together; the walks depend on it.
        """
        self.task, self.names, self.side_by_side = task, names_in_network(task), side_by_side
        self._odds, self.walker = odds, Walker(WalkTable(task.network), odds)
        self._kept: tuple[int, Walked] | None = None

    def trial(self, seed: int) -> Trial:
        """Simulate a run as a random walk through the network, with the random numbers of a seed."""
        number, column = divmod(seed, self.side_by_side)
        return self.trial_of(seed, self.together(number), column)

    def together(self, number: int) -> Walked:
        """Return the random walks of one batch, one for each of `side_by_side` consecutive seeds.

        Args:
            number: number of the batch; its first seed is `number * side_by_side`.
        """
        if self._kept is None or self._kept[0] != number:
            draws = np.random.default_rng([_STREAM, number % 2**64])
            self._kept = number, self.walker.walk(draws, self.side_by_side)
        return self._kept[1]

    def times(self, walked: Walked) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
        """Return the duration of each random walk, (n,) in [s]."""
        return np.asarray(walked.seconds.sum(axis=0) + self._odds.rest_s)

    def trial_of(self, seed: int, walked: Walked, column: int) -> Trial:
        """Convert one random walk to a trial with the records of its actions.

        A walk has only numbers. The coordinator's decisions are therefore made again for the walk's outcomes,
        which gives the names of the actions and the reason of the run's end.

        Args:
            seed: seed of the trial.
            walked: walks of a batch.
            column: index of the walk in the batch.
        """
        route = RunDecisions(self.task.network)
        ends: list[ActionEnd] = []
        time, fails, replans = 0.0, 0, -1
        outcome, status, reason = "Success", 0, ""
        columns = (walked.action[:, column], walked.ends[:, column], walked.seconds[:, column])
        for index, code, seconds in zip(*(item.tolist() for item in columns), strict=True):
            if route.arrived:
                break
            replans += not route.planned
            if not route.planned and isinstance(route.plan(), NoWay):
                break
            action, end, time = route.next, EndCode(code), time + seconds
            if index == NO_ACTION:
                route.took(Success())
                continue
            assert action.index == index, "the coordinator plans otherwise than its table"
            why = {EndCode.SUCCESS: "", EndCode.UNKNOWN: UNKNOWN}.get(end, DRAWN)
            row = self.names[index], action.source, action.target, end.outcome, time, why
            ends.append(ActionEnd(*row, for_good=end is EndCode.FOR_GOOD))
            if end is EndCode.SUCCESS:
                route.took(Success())
            elif end.outcome == "Fail":
                fails += 1
                route.failed(why, end is EndCode.FOR_GOOD)
            else:
                fails += 1
                outcome, status, reason = "GiveUp", 4, f"{action}: {why}"
                break
        if not status and not route.arrived:
            plan = route.plan()
            assert isinstance(plan, NoWay)
            replans += 1
            outcome, status, reason = "Fail", 3, plan.explanation
        if walked.skipped[column] and not status:
            outcome, status, reason = "Fail", 3, "elements were left undone"
        whole = time + self._odds.rest_s
        summary: dict[str, Any] = {"outcome": outcome, "situation": route.situation, "reason": reason}
        summary |= {"actions": len(ends), "fails": fails, "replans": max(0, replans), "sim_time_s": whole}
        return Trial(seed, status, {**summary, "seed": seed, "run_dir": "", "metrics": {}}, ends)


class WalkedSequence(Sequence[Trial]):
    """Sequence of the trials of a range of seeds, each a random walk that is computed when it is accessed."""

    def __init__(self, trials: WalkedTrials, seeds: range) -> None:
        """Prepare the trials in the order of `seeds`, without walking."""
        self.trials, self.seeds = trials, seeds

    def __len__(self) -> int:
        return len(self.seeds)

    @overload
    def __getitem__(self, at: int) -> Trial: ...
    @overload
    def __getitem__(self, at: slice) -> WalkedSequence: ...
    def __getitem__(self, at: int | slice) -> Trial | WalkedSequence:
        if isinstance(at, slice):
            return WalkedSequence(self.trials, self.seeds[at])
        return self.trials.trial(self.seeds[at])


def network_trials(task: Path, settings: Mapping[str, str]) -> WalkedTrials:
    """Return a source of trials that simulates a task with the probabilities in the task's file.

    The file is read again only if it was changed since the last call.

    Args:
        task: the task's file.
        settings: values of the task's parameters, by name.

    Raises:
        FileError: the file is invalid.
    """
    changed = task.stat().st_mtime_ns if task.exists() else 0
    return _read(task, tuple(settings.items()), changed)


@lru_cache(maxsize=4)
def _read(task: Path, settings: tuple[tuple[str, str], ...], changed: int) -> WalkedTrials:
    read = load_task(task, dict(settings))
    return WalkedTrials(read, FileOdds(read))
