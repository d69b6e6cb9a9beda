"""Rows of trials that Ctrl-C or a signal to end cuts off: what was tried until then is printed."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import active_children, get_context
from types import FrameType
from typing import Any, TypeVar

Result = TypeVar("Result")

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

    def status(self, is_wrong: bool) -> int:
        """Return the exit status of the benchmark: 130 if it was cut off, else 1 if something is wrong."""
        return CUT_OFF_STATUS if self.came else int(is_wrong)

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


def each_result(
    function: Callable[..., Result], calls: Iterable[tuple[Any, ...]], jobs: int
) -> Iterator[Result]:
    """Yield the result of each call of a function by some processes, in the order in which they end.

    Whoever cuts the loop off, by Ctrl-C or by leaving it, ends the processes at once: trials that are under
    way are not waited for.

    Args:
        function: function of a module, with results that can be sent between processes.
        calls: arguments of each call.
        jobs: number of processes.
    """
    ignored = (signal.SIGINT, signal.SIG_IGN)  # a terminal sends Ctrl-C to the processes as well
    with ProcessPoolExecutor(jobs, get_context("spawn"), signal.signal, ignored) as pool:
        try:
            for done in as_completed([pool.submit(function, *call) for call in calls]):
                yield done.result()
        except BaseException:
            for child in active_children():
                child.terminate()
            raise
