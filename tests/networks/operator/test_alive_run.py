"""Requests to a run that is over, broke off, does not answer, or is closed to the caller."""

from __future__ import annotations

import os
import shutil
import socket
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from handcart.networks.journal.journal import Journal
from handcart.networks.operator.asking import ClosedToYou, NotAlive, NotAnswering, ask, goes_on, tell_to_stop
from handcart.networks.operator.control import MAX_CONNECTIONS, Control
from tests.networks.operator.conftest import Line


@pytest.mark.parametrize("what", ["nothing", "a folder", "a file", "a broken journal"])
def test_where_no_run_is_alive_is_said_as_far_as_it_is_known(tmp_path: Path, what: str) -> None:
    folder = tmp_path / "run"
    words = {"nothing": "there is no folder", "a file": "is not a folder"}.get(what, "no journal can be read")
    if what == "a file":
        folder.write_text("")
    elif what != "nothing":
        folder.mkdir()
    if what == "a broken journal":
        os.mkfifo(folder / "journal.jsonl")
    for does in (lambda: ask(folder, {"do": "status"}), lambda: tell_to_stop(folder)):
        with pytest.raises(NotAlive, match="no run is alive") as said:
            does()
        assert words in str(said.value)


def test_a_run_that_is_over_broke_off_or_does_not_answer(folder: Path) -> None:
    with Journal(folder / "journal.jsonl") as journal:
        journal.append("RUN", 0.0, {})
        assert goes_on(folder)
        with pytest.raises(NotAnswering, match="is alive, but doesn't answer"):
            ask(folder, {"do": "status"}, 0.1)
        with Control(folder, dict, lambda: None), pytest.raises(NotAnswering, match=r"within 0\.1 s"):
            ask(folder, {"do": "status"}, 0.1)
    with pytest.raises(NotAlive, match="it broke off; handcart resume"):
        ask(folder, {"do": "status"})
    shutil.rmtree(folder / "control", ignore_errors=True)
    again = folder / "again"
    again.mkdir()
    with Journal(again / "journal.jsonl") as journal:
        journal.append("END", 0.0, {"outcome": "Fail", "situation": "here"})
    with pytest.raises(NotAlive, match="it is over, Fail in situation here"):
        tell_to_stop(again)


def test_a_queue_that_is_full_is_no_run_that_is_over(folder: Path, lines: Callable[[], Line]) -> None:
    """The run computes, and reads no waiting messages."""
    with Journal(folder / "journal.jsonl"), Control(folder, dict, lambda: None):
        for _ in range(2 * MAX_CONNECTIONS):
            try:
                lines()
            except BlockingIOError:
                break
        with pytest.raises(NotAnswering, match="doesn't answer"):
            ask(folder, {"do": "status"}, 0.1)
        for _ in range(1000):
            tell_to_stop(folder)


def test_what_answers_but_is_no_run(folder: Path) -> None:
    listening = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    listening.bind(str(folder / "control"))
    listening.listen()
    child = os.fork()
    if child == 0:  # pragma: no cover
        other, _ = listening.accept()
        other.sendall(b"hello \x1b\n")
        os._exit(0)
    with pytest.raises(NotAnswering, match="is not that of a run"):
        ask(folder, {"do": "status"})
    os.waitpid(child, 0)
    listening.close()


@pytest.mark.skipif(os.geteuid() != 0, reason="only root can become somebody else")
def test_a_folder_of_somebody_else(folder: Path, control: Any) -> None:
    """That a run is alive there or isn't can't be said."""
    child = os.fork()
    if child == 0:  # pragma: no cover
        os.seteuid(65534)
        closed = 0
        for does in (lambda: ask(folder, {"do": "status"}), lambda: tell_to_stop(folder)):
            try:
                does()
            except ClosedToYou:
                closed += 1
        os._exit(closed)
    _, status = os.waitpid(child, 0)
    assert os.waitstatus_to_exitcode(status) == 2
