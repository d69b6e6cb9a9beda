"""A key that a person holds at the terminal."""

from __future__ import annotations

import os
import select
import sys
import termios
import tty
from collections.abc import Iterator
from contextlib import contextmanager

from evaluation.bringup.jog import Lease
from files.errors import InputError

_FIRST = 30.0  # [s] in which the key is to be pressed


class NoTerminal(InputError):
    """Hold-to-run needs somebody at a terminal."""

    def __init__(self) -> None:
        super().__init__("standard input is no terminal; needed: somebody who holds a key there")


@contextmanager
def held_key() -> Iterator[Lease]:
    """Wait until the space bar is pressed; within the context the lease tells whether it still is.

    A terminal tells of a key that is held by repeating it; what it doesn't repeat within 300 ms is let go.
    Where the first repeat comes later, press it several times: `xset r rate 200 30` makes it come earlier.

    Raises:
        NoTerminal: there is none.
    """
    if not sys.stdin.isatty():
        raise NoTerminal()
    terminal = sys.stdin.fileno()
    before = termios.tcgetattr(terminal)
    tty.setcbreak(terminal)
    try:
        if not select.select([terminal], [], [], _FIRST)[0]:
            raise NoTerminal()
        yield Lease(lambda: _pressed(terminal))
    finally:
        termios.tcflush(terminal, termios.TCIFLUSH)
        termios.tcsetattr(terminal, termios.TCSADRAIN, before)


def _pressed(terminal: int) -> bool:
    """Whether the space bar came since it was asked last."""
    came = b""
    while select.select([terminal], [], [], 0.0)[0]:
        came += os.read(terminal, 1024)
    return b" " in came
