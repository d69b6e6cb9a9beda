"""Interface of the outcome probabilities and durations of actions on a walk."""

from __future__ import annotations

from enum import IntEnum
from typing import Protocol

import numpy as np

from handcart.robotics.numerics.arrays import BoolArray, FloatArray, Int8Array, Int32Array


class EndCode(IntEnum):
    """Code of how an action on a random walk ended, such as by Success, a Fail or GiveUp."""

    SUCCESS = 0
    FAIL = 1
    FOR_GOOD = 2
    """A Fail that uses up all attempts."""
    GIVE_UP = 3
    UNKNOWN = 4
    """The end of this action is unknown; the walk ends here."""

    @property
    def outcome(self) -> str:
        """Outcome (Success, Fail or GiveUp) of a simulated run that ends with this code."""
        return ("Success", "Fail", "Fail", "GiveUp", "GiveUp")[self]


class Odds(Protocol):
    """Interface of a random model of how actions end and how long they take, for n random walks at once."""

    def ends(self, action: Int32Array, context: Int32Array, drawn: FloatArray) -> Int8Array:
        """Draw how each action ends, as an `EndCode` (n,).

        Args:
            action: (n,) indices of the actions in the network.
            context: (n,) code, by `context_of`, of how often the action failed before and whether the walk's
                latest action failed.
            drawn: (n,) random numbers, uniform in [0, 1).
        """

    def seconds(
        self, action: Int32Array, context: Int32Array, ends: Int8Array, drawn: FloatArray
    ) -> FloatArray:
        """Draw the duration (n,) of each action, in [s].

        Args:
            action: (n,) indices of the actions in the network.
            context: (n,) code, by `context_of`, of how often the action failed before and whether the walk's
                latest action failed.
            ends: (n,) how the actions end, as an `EndCode`.
            drawn: (n,) random numbers, uniform in [0, 1).
        """

    @property
    def rest_s(self) -> float:
        """Time that a random walk takes in addition to the durations of its actions, in [s]."""


MOST_FAILS = 2
CONTEXT_COUNT = 2 * (MOST_FAILS + 1)


def context_of(fails: Int32Array, after_fail: BoolArray) -> Int32Array:
    """Return integer codes (n,), below `CONTEXT_COUNT`, for the Fails so far on which an action's outcome may
    depend.

    Args:
        fails: (n,) number of earlier Fails of the action; more than `MOST_FAILS` count as `MOST_FAILS`.
        after_fail: (n,) whether the preceding action, the same or another, has failed.
    """
    return np.asarray(2 * np.minimum(fails, MOST_FAILS) + after_fail, dtype=np.int32)
