"""Tickets: valid once, within half a minute, and at most a hundred of them."""

from __future__ import annotations

from pathlib import Path

import pytest

from handcart.tools.console.tickets import MAX_TICKETS, Tickets
from tests.conftest import Clock


@pytest.fixture
def tickets(monkeypatch: pytest.MonkeyPatch, clock: Clock) -> Tickets:
    monkeypatch.setattr("time.monotonic", clock)
    return Tickets()


def test_a_ticket_opens_its_file_once(tickets: Tickets) -> None:
    word, other = tickets.give(Path("a"), "report.html"), tickets.give(Path("b"), "report.html")
    assert word != other
    assert len(word) >= 32
    ticket = tickets.take(word)
    assert ticket is not None
    assert (ticket.folder, ticket.name) == (Path("a"), "report.html")
    assert tickets.take(word) is None
    assert tickets.take("never given") is None


def test_a_ticket_expires_after_half_a_minute(tickets: Tickets, clock: Clock) -> None:
    early, late = tickets.give(Path("a"), "early"), tickets.give(Path("a"), "late")
    clock.now = 29.9
    assert tickets.take(early) is not None
    clock.now = 30.0
    assert tickets.take(late) is None


def test_tickets_beyond_a_hundred_push_the_oldest_out(tickets: Tickets) -> None:
    words = [tickets.give(Path("a"), str(number)) for number in range(MAX_TICKETS + 2)]
    assert MAX_TICKETS == 100
    kept = [word for word in words if tickets.take(word)]
    assert kept == words[2:]
