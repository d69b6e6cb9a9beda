"""Lease that decides which of several open pages commands; stopping is allowed to all."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

GONE_S = 10.0
"""Time after which a disconnected page loses the lease, in [s]."""


class Lease:
    """Right to command the runs of the console, which at most one browser tab has at a time.

    Another tab can take it explicitly, and all tabs show who has it (row U8 of docs/reference/faults.md).
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        """Create a lease without a holder."""
        self._clock = clock
        self._holder, self._name, self._since_gone = "", "", 0.0
        self._open: dict[str, int] = {}

    def holds(self, tab: str) -> bool:
        """Return whether a browser tab has the right to command now."""
        return bool(tab) and self._current() == tab

    def take(self, tab: str, name: str) -> None:
        """Give the right to command to a browser tab, whichever tab had it before.

        Args:
            tab: identifier of the tab.
            name: name of the operator, which all tabs show.
        """
        self._holder, self._name = tab, name
        self._since_gone = self._clock()

    def release(self, tab: str) -> None:
        """Take the right to command from a browser tab; without effect if another tab has it."""
        if self._holder == tab:
            self._holder = self._name = ""

    def connected(self, tab: str) -> None:
        """Record that a browser tab has opened a connection to the server."""
        self._open[tab] = self._open.get(tab, 0) + 1

    def gone(self, tab: str) -> None:
        """Record that a browser tab has closed a connection; after its last one, the tab keeps the right to
        command for `GONE_S` seconds.
        """
        left = self._open.pop(tab, 1) - 1
        if left > 0:
            self._open[tab] = left
        elif self._holder == tab:
            self._since_gone = self._clock()

    def holder(self) -> dict[str, Any]:
        """Return `tab` (identifier) and `name` (operator) of the browser tab that may command; "" if none
        may.
        """
        return {"tab": self._current(), "name": self._name}

    def _current(self) -> str:
        if self._holder and self._holder not in self._open and self._clock() - self._since_gone > GONE_S:
            self._holder = self._name = ""
        return self._holder
