"""A key that a person holds at the terminal."""

from __future__ import annotations

import os
import select
import sys
import termios
import time
import tty
from collections.abc import Iterator
from contextlib import contextmanager

from handcart.evaluation.bringup.jog import KeyLease
from handcart.evaluation.bringup.operator import UnansweredQuestion
from handcart.files.errors import InputError

_FIRST = 30.0  # [s] in which the key is to be pressed


class NoTerminal(InputError):
    """Error of a motion that needs a key to be held, because standard input is not a terminal."""

    def __init__(self) -> None:
        super().__init__("standard input is not a terminal; needed: a person who holds a key there")


@contextmanager
def held_key() -> Iterator[KeyLease]:
    """Wait until the space bar is pressed, and yield an object that reports whether it is still held.

    A terminal signals a held key by repeating it. A key that is not repeated within 300 ms counts as
    released. If the terminal sends the first repeat later, press the key several times; `xset r rate 200 30`
    makes it come earlier.

    Raises:
        NoTerminal: standard input is not a terminal.
        UnansweredQuestion: the key was not pressed in time.
    """
    if not sys.stdin.isatty():
        raise NoTerminal()
    terminal = sys.stdin.fileno()
    before = termios.tcgetattr(terminal)
    tty.setcbreak(terminal)
    try:
        end = time.monotonic() + _FIRST
        while not _pressed(terminal, 0.1):
            if time.monotonic() > end:
                raise UnansweredQuestion(f"the space bar was not pressed within {_FIRST:.0f} s")
        yield KeyLease(lambda: _pressed(terminal))
    finally:
        termios.tcflush(terminal, termios.TCIFLUSH)
        termios.tcsetattr(terminal, termios.TCSADRAIN, before)


def _pressed(terminal: int, wait: float = 0.0) -> bool:
    """Return whether the space bar came since the last call, or within `wait` in [s]."""
    came = b""
    while select.select([terminal], [], [], 0.0 if came else wait)[0]:
        came += os.read(terminal, 1024)
    return b" " in came
