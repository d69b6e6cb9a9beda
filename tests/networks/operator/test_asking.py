"""Answers to a client that cannot reach a run in the usual ways."""

from __future__ import annotations

import os
import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from handcart.networks.journal.journal import Journal
from handcart.networks.operator.asking import (
    LONGEST_ANSWER,
    NotAlive,
    NotAnswering,
    ask,
    goes_on,
    tell_to_stop,
)
from handcart.networks.operator.message import LONGEST_WORD, fault_of
from handcart.networks.operator.own_page import SECURITY_HEADERS, OwnPage
from handcart.networks.run_files.socket_path import socket_path


@contextmanager
def answering(folder: Path, *answers: bytes) -> Iterator[list[bytes]]:
    """Something in that folder that takes one message, sends these bytes and hangs up."""
    heard: list[bytes] = []
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as listening:
        with socket_path(folder / "control") as name:
            listening.bind(name)
        listening.listen()

        def serve() -> None:
            other, _ = listening.accept()
            with other:
                heard.append(other.recv(1 << 16))
                for answer in answers:
                    other.sendall(answer)

        thread = threading.Thread(target=serve)
        thread.start()
        yield heard
        thread.join(20.0)


def test_an_answer_in_pieces_is_put_together(tmp_path: Path) -> None:
    with answering(tmp_path, b'{"ok": tr', b'ue, "x": 1}', b"\n") as heard:
        assert ask(tmp_path, {"do": "status"}) == {"ok": True, "x": 1}
    assert heard == [b'{"do":"status"}\n']


@pytest.mark.parametrize("answer", [b"[]\n", b'{"error": 1}\n', b"{\n", b"x" * LONGEST_ANSWER])
def test_what_is_no_answer_of_a_run_is_told(tmp_path: Path, answer: bytes) -> None:
    with (
        answering(tmp_path, answer),
        pytest.raises(NotAnswering, match=r"the answer in .* is not that of a run") as said,
    ):
        ask(tmp_path, {"do": "status"})
    assert len(str(said.value)) < 400


def test_a_run_that_hangs_up_begins_or_ends(tmp_path: Path) -> None:
    how = r"\(it hung up\): it begins, or comes to its end; handcart stop .* stops it all the same"
    with (
        Journal(tmp_path / "journal.jsonl"),
        answering(tmp_path),
        pytest.raises(NotAnswering, match=f"is alive, but doesn't answer {how}"),
    ):
        ask(tmp_path, {"do": "status"})


def test_a_run_without_its_sockets_begins_or_ends(tmp_path: Path) -> None:
    with Journal(tmp_path / "journal.jsonl"):
        for does in (lambda: ask(tmp_path, {"do": "status"}), lambda: tell_to_stop(tmp_path)):
            with pytest.raises(NotAnswering, match=r"\(No such file or directory\): it begins"):
                does()
        assert goes_on(tmp_path)
    assert not goes_on(tmp_path)


def test_a_run_in_another_place_is_named_and_a_pipe_is_no_journal(tmp_path: Path) -> None:
    with pytest.raises(
        NotAlive, match=rf"there is no folder {tmp_path / 'none'}; allowed: the folder of a running run"
    ):
        tell_to_stop(tmp_path / "none")
    os.mkfifo(tmp_path / "journal.jsonl")
    descriptors = len(os.listdir("/proc/self/fd"))
    with pytest.raises(OSError, match="it is not a file"):
        goes_on(tmp_path)
    assert len(os.listdir("/proc/self/fd")) == descriptors


def test_a_name_of_a_socket_is_short_and_its_folder_is_let_go(tmp_path: Path) -> None:
    folder = tmp_path.joinpath(*["deep" * 10] * 5)
    folder.mkdir(parents=True)
    descriptors = os.listdir("/proc/self/fd")
    with socket_path(folder / "control") as name:
        assert len(name) < 108
        assert os.path.samefile(os.path.dirname(name), folder)
    assert os.listdir("/proc/self/fd") == descriptors


@pytest.mark.parametrize(
    ("message", "fault"),
    [
        ({"do": "stop", "by": 7, "more": []}, ""),
        ({"do": "pause", "by": "x" * LONGEST_WORD, "nonce": "y" * LONGEST_WORD, "number": 1}, ""),
        ({"do": "pause", "number": None}, ""),
        ({"do": "break", "at": "a", "on": False}, ""),
        ({"do": "break"}, "at is None; allowed: a situation of the task"),
        ({"do": "step", "on": None}, "on is None; allowed: true, false"),
        ({"do": "permit", "ask": "1"}, "the question '1' is not a number; allowed: the question's number"),
        (
            {"do": "cancel", "number": True},
            "the running action True is not a number; allowed: the running action's",
        ),
        ({"do": "refuse", "action": 1.5}, "the action 1.5 is not a number; allowed: the action's number"),
        ({"do": "status", "z": 1, "b": 2}, "unknown key 'b'; allowed: by, do, nonce"),
        ({"do": "Stop"}, "unknown word 'Stop'; allowed: pause, continue, stop, cancel, restore, permit"),
    ],
)
def test_a_message_is_told_what_is_wrong_with_it(message: dict[str, object], fault: str) -> None:
    said = fault_of(message, ("a", "z"))
    assert said.startswith(fault) if fault else said == ""


def test_a_page_answers_its_own_requests_alone() -> None:
    page = OwnPage(["127.0.0.1:80", "localhost:80"])
    assert page.stranger("localhost:80", None, None) is None
    assert page.stranger("127.0.0.1:80", "http://localhost:80", "same-origin") is None
    assert page.stranger("localhost:80", None, "none") is None
    for host in (None, "localhost", "evil:80"):
        refused = page.stranger(host, None, None)
        assert refused is not None
        assert refused.status == 421
    for origin, site in (("https://localhost:80", None), ("null", None), (None, "cross-site"), (None, "")):
        refused = page.stranger("localhost:80", origin, site)
        assert refused is not None
        assert refused.status == 403
    assert page.knows(page.token)
    assert not page.knows(page.token[:-1])
    assert not page.knows("\udcff")
    assert len(page.token) == 32
    assert OwnPage([]).token != page.token
    assert SECURITY_HEADERS["Cache-Control"] == "no-store"
