"""Announcements during long silent computations, such as the first compilation."""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from handcart.robotics.numerics.compiled import hearing_of_compiling
from handcart.robotics.numerics.compiling_ahead import compiling_ahead

COMPILING_MESSAGE = "compiling inner loops; they are kept for later runs"
SILENT_TIME_S = 1.0


@contextmanager
def first_words(what: str) -> Iterator[Callable[[], None]]:
    """Print `what` to stderr after a second, unless the yielded function is called before.

    Import the modules of a command in this context, which takes longer than a second on a fresh machine.
    """
    timer = threading.Timer(SILENT_TIME_S, _say, [f"{what} ..."])
    timer.daemon = True
    timer.start()
    try:
        yield timer.cancel
    finally:
        timer.cancel()


@contextmanager
def announced(what: str) -> Iterator[None]:
    """Print `what` to stderr after a second, and announce the compilation of inner loops when it begins.

    Compilation uses all cores. Nothing is printed by a command that ends within the second.
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
