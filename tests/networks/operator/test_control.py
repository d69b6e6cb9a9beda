"""The operator's connections to a run: limits, silence, order and stops."""

from __future__ import annotations

import os
import selectors
import stat
from collections.abc import Callable
from pathlib import Path
from typing import Any

import orjson
import pytest

from handcart.networks.operator.asking import tell_to_stop
from handcart.networks.operator.control import MAX_CONNECTIONS, SILENCE_TIMEOUT_S, Control
from tests.conftest import Clock
from tests.networks.operator.conftest import Line


def test_a_stop_waits_behind_nothing(run: Any, lines: Callable[[], Line], folder: Path) -> None:
    """U9: more idle lines than there may be, half messages, floods, and a queue full of other wishes."""
    idle = [lines() for _ in range(MAX_CONNECTIONS)]
    run.look()
    for item in idle[::2]:
        item.send(b'{"do":"sta')
    for item in idle[1::2]:
        item.send(b'{"do":"pause"}\n{"do":"continue"}\n' * 300)
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


def test_each_line_gets_one_answer_a_period_in_order(control: Any, lines: Callable[[], Line]) -> None:
    flood, calm = lines(), lines()
    flood.send(b"".join(b'{"n":%d}\n' % number for number in range(100)))
    calm.send(b'{"n":-1}\n')
    control.poll()
    assert (len(flood.answers()), calm.answers()) == (1, [{"n": -1}])
    for _ in range(99):
        control.poll()
    assert [answer["n"] for answer in flood.answers()] == list(range(1, 100))


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
    for item in (*many[:20], *many[21:]):
        item.send(b"{}\n")
    control.poll()
    clock.now += 1.0
    last = lines()
    control.poll()
    assert [len(item.answers()) for item in many] == [1] * 20 + [0] + [1] * (MAX_CONNECTIONS - 21)
    assert [number for number, item in enumerate(many) if item.hung_up] == [20]
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
    assert [answer["n"] for answer in line.answers()] == [1, 2]


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
