"""Frames that are sent cyclically: our heartbeat, and the objects in the frames of each mode."""

from __future__ import annotations

import pytest
from canopen.objectdictionary import datatypes

from handcart.backends.can.bus.fault_words import fault_words
from handcart.backends.can.bus.heartbeat import Heartbeat
from handcart.backends.can.bus.pdo_layout import CIA402_MODES, layout
from handcart.backends.can.eds.eds_file import SIGNED_BITS
from tests.conftest import Clock


class Line:
    """Keeps what is sent."""

    def __init__(self) -> None:
        self.sent: list[tuple[int, bytes]] = []

    def send_message(self, can_id: int, data: bytes) -> None:
        self.sent.append((can_id, data))


def test_heartbeat_has_our_node_and_comes_a_tenth_early(clock: Clock) -> None:
    line = Line()
    heartbeat = Heartbeat(line, 0x7F, 0.1, clock)  # type: ignore[arg-type]
    for now, count in ((0.0, 1), (0.089, 1), (0.0901, 2), (0.17, 2), (0.1803, 3)):
        clock.now = now
        heartbeat.beat()
        assert len(line.sent) == count, now
    assert set(line.sent) == {(0x77F, b"\x05")}


@pytest.mark.parametrize(
    ("commanded", "kind", "mode", "objects", "transmission"),
    [
        ("velocity", "profile", 3, (0x6040, 0x60FF), 255),
        ("velocity", "csv", 9, (0x6040, 0x60FF), 1),
        ("position", "profile", 1, (0x6040, 0x607A), 255),
        ("position", "csp", 8, (0x6040, 0x607A), 1),
    ],
)
def test_frames_of_each_mode_hold_its_objects(
    commanded: str, kind: str, mode: int, objects: tuple[int, ...], transmission: int
) -> None:
    assert CIA402_MODES[commanded, kind] == mode
    planned = layout(mode)
    first, *more = planned.commands
    assert (first.number, first.objects, first.transmission, first.length) == (1, objects, transmission, 6)
    speed = [(2, (0x6081,), 255)] if mode == 1 else []
    assert [tuple(item) for item in more] == speed
    assert [tuple(answer) for answer in planned.answers] == [
        (1, (0x6041, 0x6064, 0x6061), 1),
        (2, (0x606C, 0x6077, 0x603F), 1),
    ]
    assert [answer.length for answer in planned.answers] == [7, 8]


def test_frames_leave_out_what_a_drive_lacks() -> None:
    answers = layout(9, (0x6077, 0x603F)).answers
    assert [answer.objects for answer in answers] == [(0x6041, 0x6064, 0x6061), (0x606C,)]
    assert [answer.length for answer in answers] == [7, 4]


@pytest.mark.parametrize(
    ("code", "words"),
    [
        (0x2310, "continuous over-current"),
        (0x2320, "short circuit"),
        (0x3110, "mains over-voltage"),
        (0x3120, "mains under-voltage"),
        (0x3210, "DC link over-voltage"),
        (0x3220, "DC link under-voltage"),
        (0x4210, "excess temperature of the device"),
        (0x4310, "excess temperature of the drive"),
        (0x5441, "contact fault of an input"),
        (0x7121, "motor blocked"),
        (0x7305, "incremental encoder 1"),
        (0x7306, "incremental encoder 2"),
        (0x8110, "CAN overrun: frames lost"),
        (0x8120, "CAN error passive"),
        (0x8130, "heartbeat missing"),
        (0x8140, "recovered from bus off"),
        (0x8210, "a PDO of a wrong length"),
        (0x8400, "velocity controller"),
        (0x8611, "following error"),
    ],
)
def test_fault_codes_of_the_standard_have_their_words(code: int, words: str) -> None:
    assert fault_words(code) == f"error {code:04X}h, {words}"


def test_signed_objects_have_the_bits_of_their_type() -> None:
    """CiA 301: data types 2, 3, 4 and 15h."""
    assert SIGNED_BITS == {2: 8, 3: 16, 4: 32, 0x15: 64}
    assert datatypes.INTEGER16 == 3
