"""Rows of trials that Ctrl-C or a signal to end cuts off: what was tried until then is printed."""

from __future__ import annotations

import os
import signal
from types import FrameType
from typing import Any

CUT_OFF_STATUS = 130
"""Exit status of a benchmark that was cut off."""


class CutOff:
    """Context manager around the trials of a row; a signal to end leaves it, and the row is printed."""

    def __init__(self) -> None:
        """Create the context manager; signals are handled only within it."""
        self.came = False
        """True once a signal cut the trials off."""
        self._before: Any = None

    def words(self, done: int, count: int) -> str:
        """Return a remark for the end of the row, such as ` (cut off after 3 of 20)`; "" if complete."""
        return f" (cut off after {done} of {count})" if self.came else ""

    def __enter__(self) -> CutOff:
        self._process = os.getpid()
        self._before = signal.signal(signal.SIGTERM, self._heard)
        return self

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> bool:
        signal.signal(signal.SIGTERM, self._before)
        if not isinstance(error, KeyboardInterrupt):
            return False
        self.came = True
        return True

    def _heard(self, number: int, frame: FrameType | None) -> None:
        if os.getpid() != self._process:  # a forked child ends as it would without this
            signal.signal(number, signal.SIG_DFL)
            os.kill(os.getpid(), number)
            return
        raise KeyboardInterrupt
