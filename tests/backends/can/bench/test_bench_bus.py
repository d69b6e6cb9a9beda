"""The program's end of a bench's bus: its queue, its errors, and its cable."""

from __future__ import annotations

from collections.abc import Iterator

import can
import pytest

from handcart.backends.can.bench.bench_bus import BenchBus
from tests.backends.can.cable import plug_in

FRAMES = [can.Message(arbitration_id=number, is_extended_id=False) for number in (0x201, 0x202)]


@pytest.fixture
def ends() -> Iterator[tuple[BenchBus, can.BusABC]]:
    """Return the program's end and the drives' end of one virtual channel."""
    inner, other = (can.Bus(interface="virtual", channel="test_bench_bus") for _ in range(2))
    bus = BenchBus(inner)
    yield bus, other
    bus.shutdown()
    other.shutdown()


def received(bus: can.BusABC) -> list[int]:
    return [frame.arbitration_id for frame in iter(lambda: bus.recv(0.0), None)]


def test_held_frames_are_sent_once_when_the_cable_is_back(ends: tuple[BenchBus, can.BusABC]) -> None:
    bus, other = ends
    bus.holds = True
    for frame in FRAMES:
        bus.send(frame)
    assert received(other) == []
    plug_in(bus)
    assert received(other) == [0x201, 0x202]
    plug_in(bus)
    assert received(other) == []


def test_flushed_frames_are_never_sent(ends: tuple[BenchBus, can.BusABC]) -> None:
    bus, other = ends
    bus.holds = True
    bus.send(FRAMES[0])
    bus.flush_tx_buffer()
    plug_in(bus)
    assert received(other) == []


@pytest.mark.parametrize(("flag", "words"), [("down", "Network is down"), ("full", "No buffer space")])
def test_interface_that_is_down_or_full_says_so(
    ends: tuple[BenchBus, can.BusABC], flag: str, words: str
) -> None:
    bus, other = ends
    setattr(bus, flag, True)
    with pytest.raises(can.CanOperationError, match=words):
        bus.send(FRAMES[0])
    assert received(other) == []
