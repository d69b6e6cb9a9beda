"""Bus load of frames."""

from __future__ import annotations

import pytest

from handcart.backends.can.bus.bus_load import BusLoad, CyclicFrame, frame_bits
from handcart.backends.can.devices.cyclic_frames import cyclic_frames
from handcart.backends.loading.robot_loading import load_robot


def stuffed_bits(bits: list[int]) -> int:
    """Count bits as a sender does: five equal ones are followed by an opposite one (ISO 11898-1)."""
    count, run, last = 0, 0, -1
    for bit in bits:
        run = run + 1 if bit == last else 1
        last, count = bit, count + 1
        if run == 5:
            last, run, count = 1 - bit, 1, count + 1
    return count


@pytest.mark.parametrize("length", range(9))
def test_the_worst_case_of_stuffing(length: int) -> None:
    """Five alike, then four and four: no sequence needs more stuffing."""
    bits = [0] * 5 + [bit for number in range(40) for bit in [1 - number % 2] * 4]
    stuffed = 34 + 8 * length
    assert frame_bits(length) == stuffed_bits(bits[:stuffed]) + 13


def test_load_of_a_bus() -> None:
    load = BusLoad.of([CyclicFrame("two", 0x201, 6, 0.01), CyclicFrame("one", 0x181, 8, 0.01)], 125_000)
    assert [frame.what for frame in load.frames] == ["one", "two"]
    assert load.share == pytest.approx((135 + 115) / 1250)
    assert load.burst_s == pytest.approx(250 / 125_000)
    assert not load.too_much
    assert BusLoad.of(load.frames, 35_000).too_much


def test_cyclic_frames_of_a_robot_have_their_ids_lengths_and_times() -> None:
    cart = load_robot("cart").can
    assert cart is not None
    frames = [tuple(frame) for frame in cyclic_frames(cart, 0.1)]
    beat = cart.heartbeat_ms / 1e3
    assert frames == [
        ("SYNC", 0x080, 0, 0.1),
        ("heartbeat of this program", 0x77F, 1, 0.1),  # once a period, though it is due more often
        ("left wheel: command 1", 0x201, 6, 0.1),
        ("left wheel: answer 1", 0x181, 7, 0.1),
        ("left wheel: answer 2", 0x281, 8, 0.1),
        ("left wheel: heartbeat", 0x701, 1, beat),
        ("right wheel: command 1", 0x202, 6, 0.1),
        ("right wheel: answer 1", 0x182, 7, 0.1),
        ("right wheel: answer 2", 0x282, 8, 0.1),
        ("right wheel: heartbeat", 0x702, 1, beat),
    ]
