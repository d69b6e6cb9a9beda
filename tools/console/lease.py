"""Which of several open pages commands; stopping is everybody's."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

GONE_S = 10.0
"""[s] after which a page that isn't connected any more doesn't hold it any longer."""


class Lease:
    """At most one tab has it; another takes it over explicitly, and everybody sees who has it (row U8)."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        """Nobody has it."""
        self._clock = clock
        self._holder, self._name, self._since_gone = "", "", 0.0
        self._open: dict[str, int] = {}

    def holds(self, tab: str) -> bool:
        """Whether that tab may command now."""
        return bool(tab) and self._current() == tab

    def take(self, tab: str, name: str) -> None:
        """Have it from now on, whoever had it before."""
        self._holder, self._name = tab, name
        self._since_gone = self._clock()

    def release(self, tab: str) -> None:
        """Give it back; nothing, where somebody else has it."""
        if self._holder == tab:
            self._holder = self._name = ""

    def connected(self, tab: str) -> None:
        """A tab listens."""
        self._open[tab] = self._open.get(tab, 0) + 1

    def gone(self, tab: str) -> None:
        """It doesn't any more; for a while it may come back."""
        left = self._open.pop(tab, 1) - 1
        if left > 0:
            self._open[tab] = left
        elif self._holder == tab:
            self._since_gone = self._clock()

    def holder(self) -> dict[str, Any]:
        """Who has it, for all."""
        return {"tab": self._current(), "name": self._name}

    def _current(self) -> str:
        if self._holder and self._holder not in self._open and self._clock() - self._since_gone > GONE_S:
            self._holder = self._name = ""
        return self._holder
