"""Actions of a task in recorded trials, as columns of numbers."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from handcart.evaluation.campaigns.data.action_ends import action_names
from handcart.evaluation.campaigns.data.trial import ActionEnd, Trial
from handcart.evaluation.campaigns.walks.odds import MOST_FAILS, EndCode
from handcart.networks.task.task_file import Task
from handcart.robotics.numerics.arrays import FloatArray, IntArray

FAULT_STATUS = 5  # exit status of a trial that ended by a fault of the program
_ENDS = {"Success": EndCode.SUCCESS, "Fail": EndCode.FAIL, "GiveUp": EndCode.GIVE_UP}


class SeenActions(NamedTuple):
    """Table, as arrays, of outcomes and durations of the m actions that were started in n trials."""

    trial: IntArray
    """(m,) index of the trial, from 0 to n - 1, ascending."""
    entry: IntArray
    """(m,) index of the action in the task's file."""
    context: IntArray
    """(m,) code, by `context_of`, of how often the action failed before and whether the latest action did."""
    end: IntArray
    """(m,) end of the action, as `EndCode`."""
    seconds: FloatArray
    """(m,) time since the end of the preceding action or the start of the trial, in [s]."""
    success: FloatArray
    """(n,) 1.0 for a trial that reached the goal, otherwise 0.0."""
    time_s: FloatArray
    """(n,) durations of the trials, in [s]."""
    rest_s: FloatArray
    """(n,) time of each trial after its last action, in [s]."""

    @classmethod
    def of(cls, task: Task, trials: Iterable[Trial]) -> SeenActions:
        """Collect the actions of trials, by their indices in a task's file.

        Trials that ended by a fault of the program, and actions that the task does not have, are
        skipped.
        """
        entries = {name: number for number, name in enumerate(action_names(task))}
        rows: list[tuple[int, int, int, int, float]] = []
        whole: list[tuple[float, float, float]] = []
        for trial in trials:
            if trial.status == FAULT_STATUS:
                continue
            before, after_fail = 0.0, False
            fails: Counter[tuple[str, str, str]] = Counter()
            for end in trial.actions:
                this = end[:3]
                kind = _end_of(end)
                if end.action in entries:
                    context = 2 * min(fails[this], MOST_FAILS) + after_fail
                    row = len(whole), entries[end.action], context, kind, max(0.0, end.time_s - before)
                    rows.append(row)
                before, after_fail = end.time_s, kind is not EndCode.SUCCESS
                fails[this] += after_fail
            time = float(trial.summary["sim_time_s"])
            whole.append((float(trial.success), time, max(0.0, time - before)))
        columns = np.array(rows, dtype=np.float64).reshape(-1, 5).T
        trial, entry, context, kind = columns[:4].astype(np.int64)
        success, time_s, rest_s = np.array(whole, dtype=np.float64).reshape(-1, 3).T
        return cls(trial, entry, context, kind, columns[4], success, time_s, rest_s)

    def chosen(self, trials: IntArray) -> SeenActions:
        """Return the actions of selected trials, as for a bootstrap sample.

        Args:
            trials: (k,) indices of the trials; an index may occur several times.
        """
        begin = np.searchsorted(self.trial, trials)
        count = np.searchsorted(self.trial, trials, side="right") - begin
        place = np.repeat(np.arange(len(trials)), count)
        rows = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count) + np.repeat(begin, count)
        return SeenActions(
            place,
            self.entry[rows],
            self.context[rows],
            self.end[rows],
            self.seconds[rows],
            self.success[trials],
            self.time_s[trials],
            self.rest_s[trials],
        )


def _end_of(end: ActionEnd) -> EndCode:
    return EndCode.FOR_GOOD if end.for_good else _ENDS[end.outcome]
