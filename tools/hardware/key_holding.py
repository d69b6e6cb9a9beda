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

from handcart.evaluation.bringup.jog import Lease
from handcart.evaluation.bringup.operator import NoAnswer
from handcart.files.errors import InputError

_FIRST = 30.0  # [s] in which the key is to be pressed


class NoTerminal(InputError):
    """Hold-to-run needs somebody at a terminal."""

    def __init__(self) -> None:
        super().__init__("standard input is no terminal; needed: somebody who holds a key there")


@contextmanager
def held_key() -> Iterator[Lease]:
    """Wait for the space bar, from now on; within the context the lease tells whether it is still held.

    A terminal tells of a key that is held by repeating it; what it doesn't repeat within 300 ms is let go.
    Where the first repeat comes later, press it several times: `xset r rate 200 30` makes it come earlier.

    Raises:
        NoTerminal: there is none.
        NoAnswer: nobody presses it.
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
                raise NoAnswer(f"nobody pressed the space bar within {_FIRST:.0f} s")
        yield Lease(lambda: _pressed(terminal))
    finally:
        termios.tcflush(terminal, termios.TCIFLUSH)
        termios.tcsetattr(terminal, termios.TCSADRAIN, before)


def _pressed(terminal: int, wait: float = 0.0) -> bool:
    """Whether the space bar came since it was asked last, or within `wait` in [s]."""
    came = b""
    while select.select([terminal], [], [], 0.0 if came else wait)[0]:
        came += os.read(terminal, 1024)
    return b" " in came
