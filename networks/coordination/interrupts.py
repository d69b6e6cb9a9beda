"""Effect of Ctrl-C and of a signal to end on a run."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable
from types import FrameType
from typing import Any

STOP_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


class Interrupts:
    """Context manager that turns signals to end the program (`STOP_SIGNALS`) into a stop of the run.

    Before a run has begun, a signal raises KeyboardInterrupt. During the run it stops the run, and a second
    signal does not cut the stop short (row K3 of faults.md). After the run a signal has no effect:
    the remaining records are written, and the run keeps its outcome. In threads other than the main one, the
    context manager does nothing.
    """

    def __init__(self) -> None:
        """Create the context manager; signals are handled only within it."""
        self._stop: Callable[[], object] | None = None
        self.came = False
        """True after a signal came."""
        self._before: dict[signal.Signals, Any] = {}

    def stop_by(self, stop: Callable[[], object]) -> None:
        """Register the function that stops the run that is about to begin.

        Args:
            stop: the function; called at once if a signal to end the program has already come, and again for
                each later one. It must have no effect after the run's end.
        """
        self._stop = stop
        if self.came:
            stop()

    def stop(self) -> None:
        """Stop the run as Ctrl-C would, but without a signal to the program; before a run has begun, do
        nothing.
        """
        if self._stop is not None:
            self._stop()

    def __enter__(self) -> Interrupts:
        if threading.current_thread() is threading.main_thread():
            self._before = {kind: signal.signal(kind, self._heard) for kind in STOP_SIGNALS}
        return self

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> None:
        for name, handler in self._before.items():
            signal.signal(name, handler)
        if self.came and self._stop is None and isinstance(error, Exception):
            # Libraries in C may take what the handler raises in them for an error of their own.
            raise KeyboardInterrupt from error

    def _heard(self, _number: int, _frame: FrameType | None) -> None:
        self.came = True
        if self._stop is None:
            raise KeyboardInterrupt
        self._stop()
