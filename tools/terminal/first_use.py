"""Announcements during long silent computations, such as the first compilation."""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from handcart.files.stages import hearing_of_stages
from handcart.robotics.numerics.compiled import hearing_of_compiling
from handcart.robotics.numerics.compiling_ahead import compiling_ahead

COMPILING_MESSAGE = "compiling inner loops; they are kept for later runs"
SILENT_TIME_S = 1.0


@contextmanager
def first_words(what: str) -> Iterator[Callable[[], None]]:
    """Print a message to stderr if the work in this context takes longer than a second.

    The message is not printed after the yielded function was called. A stage (`begin_stage`) that takes
    longer than a second is printed with its name, once. Import the modules of a command in this context too:
    on a fresh machine, the import takes longer than a second.

    Args:
        what: text of the message, such as "loading task.yaml".
    """
    waiting = _Waiting(what)
    with hearing_of_stages(waiting.begin):
        try:
            yield waiting.end
        finally:
            waiting.end()


class _Waiting:
    """Timer that prints what is being done once that has taken a second."""

    def __init__(self, what: str) -> None:
        self._what, self._is_over = what, False
        self._begun = set[str]()
        self._timer = self._started(what)

    def begin(self, stage: str) -> None:
        """Time a stage from its first beginning on."""
        self._timer.cancel()
        if not self._is_over and stage not in self._begun:
            self._begun.add(stage)
            self._timer = self._started(f"{self._what}: {stage}")

    def end(self) -> None:
        """Print nothing more."""
        self._is_over = True
        self._timer.cancel()

    def _started(self, words: str) -> threading.Timer:
        timer = threading.Timer(SILENT_TIME_S, _say, [f"{words} ..."])
        timer.daemon = True
        timer.start()
        return timer


@contextmanager
def announced(what: str) -> Iterator[None]:
    """Print `what` to stderr once this context lasts a second, and another message when functions are
    compiled in it.

    Other processes help to compile, on all cores. A command that ends within a second prints nothing.

    Args:
        what: text about what the command is doing.
    """
    said: list[str] = []

    def heard(compiling: bool) -> None:
        if compiling and not said:
            said.append(COMPILING_MESSAGE)
            _say(COMPILING_MESSAGE)

    with first_words(what), compiling_ahead(), hearing_of_compiling(heard):
        yield


def _say(words: str) -> None:
    print(words, file=sys.stderr, flush=True)
