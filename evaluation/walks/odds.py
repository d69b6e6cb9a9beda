"""How actions end on a walk, and how long they take."""

from __future__ import annotations

from enum import IntEnum
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Numbers = NDArray[np.int32]
Codes = NDArray[np.int8]


class End(IntEnum):
    """How an action ended, as a number."""

    SUCCESS = 0
    FAIL = 1
    FOR_GOOD = 2
    """A Fail that uses up all attempts."""
    GIVE_UP = 3
    UNKNOWN = 4
    """Nobody knows how it would end; the walk ends there."""

    @property
    def outcome(self) -> str:
        """As outcomes are called."""
        return ("Success", "Fail", "Fail", "GiveUp", "GiveUp")[self]


class Odds(Protocol):
    """Draws for many walks at once, (n,) each."""

    def ends(self, action: Numbers, context: Numbers, drawn: Floats) -> Codes:
        """How actions end.

        Args:
            action: their numbers in the network.
            context: what was before, see `context_of`.
            drawn: evenly from 0 to 1.
        """

    def seconds(self, action: Numbers, context: Numbers, ends: Codes, drawn: Floats) -> Floats:
        """How long they take, in [s], with how they end and another draw."""

    @property
    def rest_s(self) -> float:
        """What a walk takes beside its actions, in [s]."""


MOST_FAILS = 2
CONTEXTS = 2 * (MOST_FAILS + 1)


def context_of(fails: Numbers, after_fail: NDArray[np.bool_]) -> Numbers:
    """What the odds of an action may depend on, as a number from 0 to `CONTEXTS` - 1.

    Args:
        fails: how often it has failed before; from `MOST_FAILS` on it is all the same.
        after_fail: whether the action before it has failed, be it itself or another.
    """
    return np.asarray(2 * np.minimum(fails, MOST_FAILS) + after_fail, dtype=np.int32)
