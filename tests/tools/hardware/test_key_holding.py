"""A key that is held at the terminal."""

from __future__ import annotations

import os
import pty
import sys
import threading
import time
from collections.abc import Callable, Iterator

import pytest

from handcart.evaluation.bringup.operator import NoAnswer
from handcart.tools.hardware.key_holding import NoTerminal, held_key
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


def test_u6_a_held_key(typing: Callable[[bytes], None]) -> None:
    """U6: repeated, it is held; no more seen for 300 ms, or another key instead, it is let go."""
    typing(b"      ")  # before it is asked for: counts for nothing
    other, first = threading.Timer(0.2, typing, [b"x"]), threading.Timer(0.6, typing, [b" "])
    begun = time.monotonic()
    other.start()
    first.start()
    with held_key() as held:
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
    other.join()
    first.join()


def test_nobody_at_a_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    with open(os.devnull) as nothing:
        monkeypatch.setattr(sys, "stdin", nothing)
        with pytest.raises(NoTerminal), held_key():
            pass
        with pytest.raises(NoAnswer, match="no answer to 'pressed': standard input has ended"):
            TerminalOperator().confirm("pressed", "Pressed?")


def test_answers_are_asked_for_until_they_are_some(
    typing: Callable[[bytes], None], capsys: pytest.CaptureFixture[str]
) -> None:
    operator = TerminalOperator()
    typing(b"perhaps\nY\n")
    assert operator.confirm("pressed", "Pressed?")
    typing(b"far\n0,103\n")
    assert operator.number("way", "How far [m]?", lambda: 1.0) == 0.103
    assert "a number, please" in capsys.readouterr().err
