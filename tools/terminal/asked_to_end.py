"""Requests to end a command that serves until then."""

from __future__ import annotations

import signal


class AskedToEnd:
    """Handler of Ctrl-C and termination signals, which records them until the program checks for them.

    A KeyboardInterrupt could be lost, because a callback of a library may catch all exceptions.
    """

    def __init__(self) -> None:
        """Take the signals over for the rest of the process."""
        self._signals: list[int] = []
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            signal.signal(number, lambda kind, _: self._signals.append(kind))

    def __bool__(self) -> bool:
        return bool(self._signals)

    @property
    def status(self) -> int:
        """Exit status that a shell expects: 128 and the first signal's number; 0 without a signal."""
        return 128 + self._signals[0] if self._signals else 0
