"""A key that is held at the terminal."""

from __future__ import annotations

import array
import fcntl
import os
import pty
import sys
import termios
import threading
import time
import tty
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import pytest

from handcart.evaluation.bringup.operator import UnansweredQuestion
from handcart.tools.terminal.key_holding import NoTerminal, held_key
from handcart.tools.terminal.terminal_operator import TerminalOperator


@pytest.fixture
def typing(monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[bytes], None]]:
    """A terminal as standard input; types into it."""
    ours, theirs = pty.openpty()
    with os.fdopen(theirs, "r") as terminal:
        monkeypatch.setattr(sys, "stdin", terminal)
        yield lambda keys: void(os.write(ours, keys))
    os.close(ours)


def void(_: object) -> None:
    """Nothing."""


def typed_ahead(typing: Callable[[bytes], None], keys: bytes) -> None:
    """Type keys that are not read yet, and wait until the kernel has carried them to the other end."""
    terminal, waiting = sys.stdin.fileno(), array.array("i", [0])
    tty.setcbreak(terminal)  # else only whole lines count as waiting
    typing(keys)
    while waiting[0] < len(keys):
        fcntl.ioctl(terminal, termios.FIONREAD, waiting)


@contextmanager
def typed_later(typing: Callable[[bytes], None], keys: dict[float, bytes]) -> Iterator[None]:
    """Type each of them so many seconds from now; none once the context is left."""
    timers = [threading.Timer(after, typing, [key]) for after, key in keys.items()]
    for timer in timers:
        timer.start()
    try:
        yield
    finally:
        for timer in timers:
            timer.cancel()
            timer.join()


def test_u6_a_held_key(typing: Callable[[bytes], None]) -> None:
    """U6: repeated, it is held; no more seen for 300 ms, or another key instead, it is let go."""
    typed_ahead(typing, b"      ")  # before it is asked for: counts for nothing
    begun = time.monotonic()
    with typed_later(typing, {0.2: b"x", 0.6: b" "}), held_key() as held:
        assert time.monotonic() - begun > 0.55  # another key starts nothing
        end = time.monotonic() + 0.6
        while time.monotonic() < end:
            typing(b" ")
            time.sleep(0.02)
            assert held()
        typing(b"xxxx")
        begun = time.monotonic()
        while held():
            time.sleep(0.005)
            assert time.monotonic() < begun + 5.0
        assert time.monotonic() - begun > 0.2
        typing(b" ")
        time.sleep(0.05)
        assert not held()


def test_nobody_at_a_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    with open(os.devnull) as nothing:
        monkeypatch.setattr(sys, "stdin", nothing)
        with pytest.raises(NoTerminal), held_key():
            pass
        with pytest.raises(UnansweredQuestion, match="no answer to 'pressed': standard input has ended"):
            TerminalOperator().confirm("pressed", "Pressed?")


def test_answers_are_asked_for_until_they_are_some(
    typing: Callable[[bytes], None], capsys: pytest.CaptureFixture[str]
) -> None:
    operator = TerminalOperator()
    typing(b"perhaps\nY\n")
    assert operator.confirm("pressed", "Pressed?")
    typing(b"far\nnan\ninf\n0,103\n")
    assert operator.number("way", "How far [m]?", lambda: 1.0) == 0.103
    assert "a number, please" in capsys.readouterr().err
