"""Two robots or benches on one channel: found before either disturbs the other."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from typing import Any

import can
import pytest
from can.interfaces.virtual import VirtualBus

from handcart.backends.can.bench.bench import Bench
from handcart.backends.can.bus import channel_use
from handcart.backends.can.bus.channel_use import other_channel_hint, own_channel, taken_by
from handcart.backends.can.bus.errors import Stranger
from handcart.backends.can.can_backend import CanBackend
from handcart.backends.description.robot_file import RobotFile

CHANNEL = "a channel for one"
Frame = tuple[int, bytes]
SYNC, HEARTBEAT = (0x080, b""), (0x77F, b"\x05")


@pytest.fixture
def bus(monkeypatch: pytest.MonkeyPatch) -> Iterator[VirtualBus]:
    """Our end, and short waiting."""
    monkeypatch.setattr(channel_use, "LISTEN_S", 0.05)
    monkeypatch.setattr(channel_use, "ANSWER_S", 0.05)
    with VirtualBus(CHANNEL) as ours:
        yield ours


@pytest.fixture
def others() -> Iterator[Callable[[Frame], VirtualBus]]:
    """Yield a function that puts another node's frame on the channel and returns its end."""
    with ExitStack() as opened:

        def send(frame: Frame) -> VirtualBus:
            theirs = opened.enter_context(VirtualBus(CHANNEL))
            theirs.send(can.Message(arbitration_id=frame[0], data=frame[1], is_extended_id=False))
            return theirs

        yield send


@pytest.mark.parametrize(
    ("frame", "is_shared", "who"),
    [
        (SYNC, True, "another master (080h)"),
        ((0x000, b"\x01\x09"), True, "another master (000h)"),
        ((0x609, bytes(8)), True, "another master (609h)"),
        ((0x701, b"\x05"), True, "a node 1 (701h)"),
        ((0x709, b"\x05"), False, "a node 9 (709h)"),
        ((0x709, b"\x05"), True, ""),
    ],
)
def test_channel_in_use_is_found_by_listening_alone(
    bus: VirtualBus, others: Callable[[Frame], VirtualBus], frame: Frame, is_shared: bool, who: str
) -> None:
    """C23: a question would stop a robot that runs there."""
    theirs = others(frame)
    assert taken_by(bus, {1, 2}, is_shared) == who
    heard = theirs.recv(0.0)
    assert (heard is None) == bool(who)


def test_idle_bench_on_the_channel_is_found_by_asking(bus: VirtualBus, cart: RobotFile) -> None:
    """C23: drives that are not set up send nothing by themselves."""
    assert cart.can is not None
    bench, end = Bench(cart, cart.can, None, VirtualBus(CHANNEL)), threading.Event()
    while bus.recv(0.0):  # boot-up messages
        pass

    def serve() -> None:
        while not end.wait(0.001):
            bench.serve()

    thread = threading.Thread(target=serve)
    thread.start()
    try:
        assert taken_by(bus, {1, 2}, is_shared=True) == "a node 1 (581h)"
        assert taken_by(bus, {5}, is_shared=True) == ""
        assert taken_by(bus, {5}, is_shared=False) == "a node 1 (581h)"
    finally:
        end.set()
        thread.join()
        bench.close()


@pytest.mark.parametrize("frame", [SYNC, HEARTBEAT])
def test_program_is_refused_before_its_first_frame(
    cart: RobotFile, others: Callable[[Frame], VirtualBus], frame: Frame, monkeypatch: pytest.MonkeyPatch
) -> None:
    """C23: its set-up would stop the drives that another program drives."""
    assert cart.can is not None
    spec = cart.can.model_copy(update={"interface": "virtual", "channel": CHANNEL})
    theirs: list[Any] = []
    opened = can.Bus

    def open_beside(*args: Any, **options: Any) -> Any:
        ours = opened(*args, **options)
        theirs.append(others(frame))
        return ours

    monkeypatch.setattr(can, "Bus", open_beside)
    with pytest.raises(Stranger, match="allowed: one master, and a channel for each robot"):
        CanBackend(cart.model_copy(update={"can": spec}), None)
    assert theirs[0].recv(0.0) is None


def test_channels_of_robots_are_groups_of_their_own() -> None:
    channels = {own_channel(f"robot {number}") for number in range(200)}
    assert len(channels) > 195
    assert own_channel("cart") == own_channel("cart")
    assert all(1 <= int(part) <= 254 for channel in channels for part in channel.split(".")[2:])
    assert own_channel("cart") in other_channel_hint("udp_multicast", "cart")
    assert "such as" not in other_channel_hint("socketcan", "cart")
