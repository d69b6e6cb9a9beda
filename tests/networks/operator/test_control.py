"""The operator's connection to a run, with other clients that send anything."""

from __future__ import annotations

import json
import os
import selectors
import shutil
import socket
import stat
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import orjson
import pytest

from benchmarks.damage.fuzzed_messages import fuzzed_messages
from handcart.networks.coordination.coordinator import Coordinator
from handcart.networks.coordination.supervision import MAX_REQUESTS as REQUESTS_THAT_WAIT
from handcart.networks.graph.network import Action
from handcart.networks.journal.journal import Journal
from handcart.networks.operator.asking import ClosedToYou, NotAlive, NotAnswering, ask, goes_on, tell_to_stop
from handcart.networks.operator.control import MAX_CONNECTIONS, SILENCE_TIMEOUT_S, Control
from handcart.networks.operator.operation import Operation
from handcart.networks.operator.permits import Permits
from tests.conftest import Clock
from tests.networks.conftest import Stand

FAULT = "a fault in handcart"


class Line:
    """The other end of a line."""

    def __init__(self) -> None:
        self.socket = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        self.socket.setblocking(False)  # connecting waits where the queue is full, else
        self.came = b""

    def connect(self, folder: Path) -> None:
        self.socket.connect(str(folder / "control"))

    def send(self, message: bytes) -> None:
        self.socket.sendall(message)

    def answers(self) -> list[dict[str, Any]]:
        """Return the complete answers so far."""
        while self._more():
            pass
        *whole, self.came = self.came.split(b"\n")
        return [json.loads(each) for each in whole]

    def _more(self) -> bool:
        try:
            new = self.socket.recv(1 << 16)
        except BlockingIOError:
            return False
        self.came += new
        return bool(new)

    @property
    def hung_up(self) -> bool:
        try:
            return self.socket.recv(1) == b""
        except BlockingIOError:
            return False
        except ConnectionResetError:
            return True


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return Path()


@pytest.fixture
def lines(folder: Path) -> Iterator[Callable[[], Line]]:
    """Opens lines; all are closed in the end."""
    opened: list[Line] = []

    def open_one() -> Line:
        opened.append(Line())
        opened[-1].connect(folder)
        return opened[-1]

    yield open_one
    for each in opened:
        each.socket.close()


@pytest.fixture
def run(stand: Stand, folder: Path) -> Iterator[Any]:
    """A run before its first period, that listens."""
    coordinator = Coordinator(stand.network("a z go 1"), stand.robot, stand.model)
    with Operation(folder, coordinator, Permits(), stand.robot) as operation:
        double: Any = operation
        double.coordinator, double.stand = coordinator, stand
        yield double


@pytest.fixture
def control(folder: Path, clock: Clock) -> Iterator[Any]:
    """Answers each message with itself."""
    stops: list[None] = []
    with Control(folder, dict, lambda: stops.append(None), clock) as listening:
        double: Any = listening
        double.stops = stops
        yield double


def test_every_message_that_is_none_is_answered_in_words(run: Any, lines: Callable[[], Line]) -> None:
    """U11: of all JSON types, huge, deep, binary, half; more: `python -m benchmarks.hostile.control`."""
    taken = 0
    for message in fuzzed_messages(400, seed=1):
        line, rest = lines(), message + b"\n"
        answers: list[dict[str, Any]] = []
        while not answers:  # a line that is too long is answered before it is all there
            sent, rest = rest[:3000], rest[3000:]
            line.send(sent)
            run.look()
            answers = line.answers()
        (answer,) = answers
        assert answer["ok"] == is_taken(message), message
        assert answer["ok"] or ("allowed" in answer["error"] or "permission" in answer["error"]), message
        assert FAULT not in answer.get("error", "")
        taken += answer["ok"]
        line.socket.close()
        run.look()
    assert taken > 5
    assert run.coordinator.life.state.value == "planning"


def is_taken(line: bytes) -> bool:
    """Return whether a run obeys a line, as decided by Python's JSON."""
    try:
        message = json.loads(line) if len(line) <= 4096 else None
    except (ValueError, RecursionError):
        return False
    return message in ({"do": "status"}, {"do": "pause"}, {"do": "continue"})


@pytest.mark.parametrize(
    ("message", "words"),
    [
        ({"do": ["stop"]}, "unknown word ['stop']; allowed: pause, continue"),
        ({"do": {}}, "unknown word {}"),
        ({}, "the key 'do' is missing"),
        ({"do": "permit", "action": True}, "the action True is not a number"),
        ({"do": "permit", "action": 0.0}, "the action 0.0 is not a number"),
        ({"do": "permit", "acton": 3}, "unknown key 'acton'; allowed: action, ask, by, do, nonce"),
        ({"do": "x\x1b[2J"}, "unknown word 'x\\x1b[2J'"),
    ],
)
def test_what_is_wrong_with_a_message(run: Any, message: dict[str, Any], words: str) -> None:
    answer = run.answer(message)
    assert not answer["ok"]
    assert words in answer["error"]


def test_a_stop_waits_behind_nothing(run: Any, lines: Callable[[], Line], folder: Path) -> None:
    """U9: more idle lines than there may be, half messages, floods, and a queue full of other wishes."""
    idle = [lines() for _ in range(MAX_CONNECTIONS)]
    run.look()
    for each in idle[::2]:
        each.send(b'{"do":"sta')
    for each in idle[1::2]:
        each.send(b'{"do":"pause"}\n{"do":"continue"}\n' * 300)
    for _ in range(5):
        run.look()
    tell_to_stop(folder)
    run.look()
    end = run.stand.finish(run.coordinator)
    assert (end.outcome, end.actions) == ("Cancelled", 0)


def test_a_stop_on_the_line_is_heard_beside_idle_ones(run: Any, lines: Callable[[], Line]) -> None:
    """U8, U11: eight that say nothing made `handcart stop` say that no run is alive."""
    for _ in range(3 * MAX_CONNECTIONS):
        lines()
        run.look()
    asking = lines()
    asking.send(b'{"do":"stop"}\n')
    run.look()
    assert asking.answers()[0]["ok"]
    assert run.stand.finish(run.coordinator).outcome == "Cancelled"


def test_a_stop_of_somebody_who_has_hung_up_is_heard(run: Any, lines: Callable[[], Line]) -> None:
    line = lines()
    line.send(b'{"do":"status"}\n{"do":"status"}\n{"do":"stop"}')
    line.socket.close()
    for _ in range(5):
        run.look()
    assert run.stand.finish(run.coordinator).outcome == "Cancelled"


def test_waiting_requests_are_limited_but_a_stop_is_not(run: Any) -> None:
    taken = [run.answer({"do": word})["ok"] for _ in range(50) for word in ("pause", "continue")]
    assert taken == [True] * REQUESTS_THAT_WAIT + [False] * (100 - REQUESTS_THAT_WAIT)
    assert run.answer({"do": "stop"})["ok"]
    assert run.stand.finish(run.coordinator).outcome == "Cancelled"


def test_each_line_gets_one_answer_a_period_in_order(control: Any, lines: Callable[[], Line]) -> None:
    flood, calm = lines(), lines()
    flood.send(b"".join(b'{"n":%d}\n' % number for number in range(100)))
    calm.send(b'{"n":-1}\n')
    control.poll()
    assert (len(flood.answers()), calm.answers()) == (1, [{"n": -1}])
    for _ in range(99):
        control.poll()
    assert [each["n"] for each in flood.answers()] == list(range(1, 100))


def test_who_does_not_read_makes_nobody_else_wait(control: Any, lines: Callable[[], Line]) -> None:
    deaf, calm = lines(), lines()
    request = orjson.dumps({"n": "x" * 4000}) + b"\n"
    sent = 0
    for _ in range(1000):
        try:
            sent += deaf.socket.send(request)
        except BlockingIOError:
            break
        control.poll()
    assert sent < 1000 * len(request)  # it came to a halt, and nothing was lost of it
    calm.send(b'{"n":1}\n')
    control.poll()
    assert calm.answers() == [{"n": 1}]


def test_a_message_that_is_too_long_is_told_and_its_line_closed(
    control: Any, lines: Callable[[], Line]
) -> None:
    line = lines()
    line.send(b"x" * 5000)
    for _ in range(3):
        control.poll()
    assert "more than 4096 bytes" in line.answers()[0]["error"]
    assert line.hung_up


def test_a_line_on_which_nothing_comes_is_closed(
    control: Any, lines: Callable[[], Line], clock: Clock
) -> None:
    """U11: half a message is nothing whole."""
    idle, half, busy = lines(), lines(), lines()
    half.send(b'{"n"')
    for _ in range(3):
        busy.send(b"{}\n")
        control.poll()
        clock.now += 0.4 * SILENCE_TIMEOUT_S
    control.poll()
    assert (idle.hung_up, half.hung_up) == (True, True)
    busy.send(b"{}\n")
    control.poll()
    assert len(busy.answers()) == 4


def test_of_too_many_lines_the_one_that_was_silent_longest_is_closed(
    control: Any, lines: Callable[[], Line], clock: Clock
) -> None:
    """U11: active clients keep their connection."""
    many = []
    for _ in range(MAX_CONNECTIONS):
        many.append(lines())
        control.poll()
    clock.now += 1.0
    for each in (*many[:20], *many[21:]):
        each.send(b"{}\n")
    control.poll()
    clock.now += 1.0
    last = lines()
    control.poll()
    assert [len(each.answers()) for each in many] == [1] * 20 + [0] + [1] * (MAX_CONNECTIONS - 21)
    assert [number for number, each in enumerate(many) if each.hung_up] == [20]
    last.send(b"{}\n")
    control.poll()
    assert last.answers() == [{}]


def test_only_its_owner_may_operate_a_run(folder: Path, control: Any) -> None:
    """U11: by either socket."""
    for name in ("control", "control.stop"):
        assert stat.S_IMODE(os.stat(folder / name).st_mode) & 0o077 == 0


def test_who_asked_more_than_once_is_not_waited_with(
    control: Any, lines: Callable[[], Line], monkeypatch: pytest.MonkeyPatch
) -> None:
    waited, plain = [], selectors.DefaultSelector.select

    def select(self: selectors.DefaultSelector, timeout: float | None = None) -> Any:
        waited.append(timeout)
        return plain(self, 0.0)

    monkeypatch.setattr(selectors.DefaultSelector, "select", select)
    line = lines()
    for _ in range(4):
        control.poll(5.0)
        if waited[-1] and not waited[:-1]:
            line.send(b'{"n":1}\n{"n":2}\n')
    assert waited == [5.0, 5.0, 0.0, 5.0]
    assert [each["n"] for each in line.answers()] == [1, 2]


def test_an_answer_holds_for_one_start_of_one_action(stand: Stand) -> None:
    (action,) = stand.network("a z go 1").actions
    permits = Permits(step=True)
    asked: list[Action] = []
    permits.asking = asked.append
    for permitted in (True, False):
        assert permits(action) is None
        permits.answer(permitted)
        assert permits(action) is permitted
    assert permits(action) is None
    assert asked == [action] * 3


def test_a_fault_in_answering_is_told_and_nothing_more(folder: Path, lines: Callable[[], Line]) -> None:
    def fails(message: Mapping[str, Any]) -> Mapping[str, Any]:
        raise KeyError("x")

    with Control(folder, fails, lambda: None) as listening:
        line = lines()
        line.send(b"{}\n")
        listening.poll()
        assert line.answers() == [{"ok": False, "error": "a fault in handcart: KeyError: 'x'"}]


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


def test_answer_that_does_not_fit_at_once_is_sent_when_there_is_room(
    folder: Path, lines: Callable[[], Line], clock: Clock
) -> None:
    """While the rest waits the line is writable for the selector, and afterwards readable again."""
    long = "x" * 3_000_000
    with Control(folder, lambda request: {"ok": True, "long": long}, lambda: None, clock) as control:
        line = lines()
        line.send(b"{}\n")
        double: Any = control
        answers, waiting = list[dict[str, Any]](), set[int]()
        while not answers:
            control.poll(0.01)
            waiting |= {key.events for key in double._selector.get_map().values()}
            answers = line.answers()
        assert answers == [{"ok": True, "long": long}]
        assert selectors.EVENT_WRITE in waiting
        control.poll()
        assert {key.events for key in double._selector.get_map().values()} == {selectors.EVENT_READ}
