"""Outcome probabilities given in a task's file."""

from __future__ import annotations

import numpy as np

from handcart.files.errors import FileError
from handcart.networks.analysis.figures import missing_chances
from handcart.networks.task.task_file import Task
from handcart.robotics.numerics.arrays import FloatArray, Int8Array, Int32Array

from .odds import EndCode


class FileOdds:
    """Random model of actions with the probabilities and costs in the task's file.

    It uses each action's `p`, `p_give_up` and `cost_s`. Attempts are independent, and no Fail is permanent.
    """

    rest_s = 0.0

    def __init__(self, task: Task) -> None:
        """Read the odds of a task; raise `FileError` if an action has no probability `p`."""
        wrong = "no probability `p`; needed: one for each action, to draw how it ends"
        if missing := missing_chances(task):
            raise FileError(task.document.finding(("actions", number), wrong) for number in missing)
        entries = [None if entry is None else task.file.actions[entry] for entry in task.entries]
        self._success = np.array([1.0 if item is None else item.p_success or 0.0 for item in entries])
        self._give_up = np.array([0.0 if item is None else item.p_give_up for item in entries])
        self._cost = np.array([action.cost_s for action in task.network.actions])

    def ends(self, action: Int32Array, context: Int32Array, drawn: FloatArray) -> Int8Array:
        """Draw for each action whether it ends in Success, Fail or GiveUp (`EndCode`, (n,)), with the
        probabilities of the task file.

        Args:
            action: (n,) indices of the actions in the network.
            context: (n,) code of how often the action failed before and whether the walk's latest action
                failed; not used.
            drawn: (n,) random numbers, uniform in [0, 1).
        """
        ends = np.full(len(action), EndCode.FAIL, dtype=np.int8)
        ends[drawn >= 1.0 - self._give_up[action]] = EndCode.GIVE_UP
        ends[drawn < self._success[action]] = EndCode.SUCCESS
        return ends

    def seconds(
        self, action: Int32Array, context: Int32Array, ends: Int8Array, drawn: FloatArray
    ) -> FloatArray:
        """Return the duration (n,) of each action: its cost in the task file, in [s].

        Args:
            action: (n,) indices of the actions in the network.
            context: (n,) not used.
            ends: (n,) not used.
            drawn: (n,) not used.
        """
        return np.asarray(self._cost[action])
