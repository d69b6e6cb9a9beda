"""Each watch of the bus alone: at which frame and which time it trips, and at which it does not."""

from __future__ import annotations

import can
import pytest

from handcart.backends.can.bus.errors import (
    ControllerFault,
    Emergency,
    NodeRestarted,
    Overloaded,
    SilentDrive,
    Stranger,
    TwoNodes,
)
from handcart.backends.can.watches.controller_watch import ControllerWatch
from handcart.backends.can.watches.emergency_watch import EmergencyWatch
from handcart.backends.can.watches.node_watch import NodeWatch
from handcart.backends.can.watches.stranger_watch import StrangerWatch
from handcart.backends.can.watches.traffic_watch import TrafficWatch
from handcart.backends.can.watches.watch import Watch

NAMES = {1: "the left drive", 2: "the right drive"}
WARNING, PASSIVE = bytes([0, 0x04]), bytes([0, 0x10])
NODE_LIKE = ({"is_extended_id": True}, {"is_remote_frame": True}, {"is_fd": True}, {"is_error_frame": True})
"""Frames that no CANopen node sends."""


def frame(can_id: int, data: bytes = b"", **kind: bool) -> can.Message:
    return can.Message(arbitration_id=can_id, data=data, **{"is_extended_id": False, **kind})


def error_frame(classes: int, data: bytes = bytes(8)) -> can.Message:
    return frame(classes, data, is_error_frame=True)


def is_quiet(watch: Watch, now: float = 0.0) -> bool:
    watch.check(now)
    return True


def controller(state: can.BusState = can.BusState.ACTIVE) -> ControllerWatch:
    return ControllerWatch(lambda: state)


def test_controller_state_of_the_interface_trips() -> None:
    assert is_quiet(controller())
    with pytest.raises(ControllerFault, match="bus-off"):
        controller(can.BusState.ERROR).check(0.0)
    with pytest.raises(ControllerFault, match="error-passive"):
        controller(can.BusState.PASSIVE).check(0.0)


def test_controller_error_frames_trip_and_others_do_not() -> None:
    for said, words in ((error_frame(0x40), "bus-off"), (error_frame(0x04, PASSIVE), "error-passive")):
        watch = controller()
        watch.hear(said, False, 0.0)
        with pytest.raises(ControllerFault, match=words):
            watch.check(0.0)
    watch = controller()
    watch.hear(frame(0x40), False, 0.0)  # an NMT frame, no error frame
    watch.hear(error_frame(0x02, PASSIVE), False, 0.0)  # of another class: its second byte says nothing
    watch.hear(error_frame(0x04, bytes([0])), False, 0.0)
    assert is_quiet(watch, 100.0)


def test_controller_warning_trips_after_a_second_from_the_first() -> None:
    watch = controller()
    watch.hear(error_frame(0x04, WARNING), False, 10.0)
    watch.hear(error_frame(0x04, WARNING), False, 10.9)
    assert is_quiet(watch, 10.99)
    with pytest.raises(ControllerFault, match=r"in warning for 1 s"):
        watch.check(11.0)
    watch.hear(error_frame(0x04), False, 11.1)
    assert is_quiet(watch, 20.0)
    watch.hear(error_frame(0x04, WARNING), False, 20.0)
    assert is_quiet(watch, 20.5)


def emergencies(*allowed: int) -> EmergencyWatch:
    watch = EmergencyWatch(NAMES, allowed)
    watch.begin(0.0)
    return watch


def emcy(node: int, code: int) -> can.Message:
    return frame(0x80 + node, code.to_bytes(2, "little") + bytes(6))


def test_emergency_of_any_node_trips_and_names_the_first() -> None:
    watch = emergencies()
    watch.hear(emcy(5, 0x4310), False, 0.0)
    watch.hear(emcy(1, 0x2310), False, 0.0)
    with pytest.raises(Emergency, match=r"node 5.*4310h, excess temperature of the drive"):
        watch.check(0.0)
    watch = emergencies()
    watch.hear(emcy(2, 0x8150), False, 0.0)
    with pytest.raises(TwoNodes, match=r"the right drive.*8150h"):
        watch.check(0.0)


def test_emergency_that_is_none_or_allowed_does_not_trip() -> None:
    watch = emergencies(0x4310)
    watch.hear(emcy(1, 0x4310), False, 0.0)
    watch.hear(emcy(1, 0x0000), False, 0.0)  # the error is over
    watch.hear(emcy(1, 0x2310), True, 0.0)  # sent by us
    watch.hear(emcy(0, 0x2310), False, 0.0)  # a SYNC
    watch.hear(frame(0x81, b"\x10\x23"), False, 0.0)  # too short
    watch.hear(frame(0x181, bytes(emcy(1, 0x2310).data)), False, 0.0)
    for kind in NODE_LIKE:
        data = b"" if "is_remote_frame" in kind else bytes(emcy(1, 0x2310).data)
        watch.hear(frame(0x81, data, **kind), False, 0.0)
    assert is_quiet(watch)
    early = EmergencyWatch(NAMES, ())
    early.hear(emcy(1, 0x2310), False, 0.0)
    early.begin(1.0)
    assert is_quiet(early, 1.0)


def nodes() -> NodeWatch:
    watch = NodeWatch(NAMES, 0.2)
    watch.begin(10.0)
    return watch


def heartbeat(node: int, state: int = 5) -> can.Message:
    return frame(0x700 + node, bytes([state]))


def test_node_without_a_heartbeat_trips_after_the_allowed_time() -> None:
    watch = nodes()
    for node in NAMES:
        watch.hear(heartbeat(node), False, 10.1)
    watch.hear(frame(0x701, b"\x05\x05"), False, 10.2)  # no heartbeat: two bytes
    watch.hear(heartbeat(2), False, 10.2)
    assert is_quiet(watch, 10.3)
    with pytest.raises(SilentDrive, match=r"the left drive.*0\.21 s"):
        watch.check(10.31)
    early = NodeWatch(NAMES, 0.2)
    assert is_quiet(early, 100.0)
    early.begin(100.0)
    with pytest.raises(SilentDrive):
        early.check(100.3)


@pytest.mark.parametrize(
    ("state", "words"), [(0, "has booted"), (4, "STOPPED"), (127, "PRE-OPERATIONAL"), (3, "the state 3")]
)
def test_node_that_leaves_operational_trips(state: int, words: str) -> None:
    watch = nodes()
    watch.hear(frame(0x601, bytes(8)), True, 10.0)
    watch.hear(heartbeat(1, state), False, 10.1)
    with pytest.raises(NodeRestarted, match=words):
        watch.check(10.1)


def test_node_may_boot_before_anything_was_written_to_it() -> None:
    watch = NodeWatch(NAMES, 0.2)
    watch.hear(heartbeat(1, 0), False, 0.0)
    watch.hear(heartbeat(1, 127), False, 0.0)
    watch.hear(heartbeat(7, 4), False, 0.0)  # a node that is not a drive
    watch.hear(frame(0x602, bytes(8)), True, 0.0)
    watch.hear(heartbeat(1, 0), False, 0.0)
    assert is_quiet(watch)
    watch.hear(heartbeat(2, 0), False, 0.0)
    with pytest.raises(NodeRestarted, match="the right drive"):
        watch.check(0.0)


def test_node_that_answers_twice_is_two_nodes() -> None:
    watch = nodes()
    for _ in range(3):
        watch.hear(frame(0x80), True, 10.0)
        watch.hear(frame(0x181, bytes(8)), False, 10.0)
        watch.hear(frame(0x182, bytes(8)), False, 10.0)
        watch.hear(frame(0x601, bytes(8)), True, 10.0)
        watch.hear(frame(0x581, bytes(8)), False, 10.0)
    assert is_quiet(watch, 10.0)
    watch.hear(frame(0x182, bytes(8)), False, 10.0)
    with pytest.raises(TwoNodes, match=r"the right drive.*two answers to one SYNC"):
        watch.check(10.0)
    watch = nodes()
    watch.hear(frame(0x581, bytes(8)), False, 10.0)
    with pytest.raises(TwoNodes, match=r"the left drive.*two answers to one SDO request"):
        watch.check(10.0)


@pytest.mark.parametrize(
    "can_id", [0x000, 0x080, 0x201, 0x302, 0x401, 0x502, 0x601, 0x602, 0x77F], ids=lambda item: f"{item:03X}"
)
def test_stranger_with_a_frame_of_the_master_trips(can_id: int) -> None:
    watch = StrangerWatch(NAMES, 0x7F)
    watch.hear(frame(can_id, b"\x2b"), True, 0.0)  # our own
    for kind in NODE_LIKE:
        watch.hear(frame(can_id, b"", **kind), False, 0.0)
    watch.hear(frame(0x603), False, 0.0)  # to an unknown node
    watch.hear(frame(0x181), False, 0.0)
    assert is_quiet(watch)
    watch.hear(frame(can_id, b"\x2b\x01"), False, 0.0)
    watch.hear(frame(can_id, b"\x00"), False, 0.0)
    with pytest.raises(Stranger, match=rf"{can_id:03X}h \[2b 01\]"):
        watch.check(0.0)


def traffic(watch: TrafficWatch, frames: int, now: float, bytes_: int = 8) -> None:
    for _ in range(frames):
        watch.hear(frame(0x181, bytes(bytes_)), False, now)


def test_traffic_above_seven_tenths_trips_after_half_a_window() -> None:
    """A frame of 8 bytes takes 123 bits with its stuffing: 57 in 0.1 s are 70.1 % of 100 kbit/s."""
    watch = TrafficWatch(100_000, lambda: 0)
    watch.begin(0.0)
    traffic(watch, 56, 1.0)
    for now in (1.0, 1.06, 1.09):
        assert is_quiet(watch, now)
    watch.begin(2.0)
    traffic(watch, 57, 2.0)
    assert is_quiet(watch, 2.0)
    assert is_quiet(watch, 2.045)
    with pytest.raises(Overloaded, match=r"70 % for 0\.1 s; allowed: 70 %$"):
        watch.check(2.055)
    assert is_quiet(watch, 2.11)  # they are out of the window
    watch.begin(3.0)
    traffic(watch, 10, 3.0)
    traffic(watch, 87, 3.0, bytes_=0)  # 51 bits each
    assert is_quiet(watch, 3.0)
    assert is_quiet(watch, 3.06)


def test_traffic_of_ten_malformed_frames_in_a_second_trips() -> None:
    count = [100]
    watch = TrafficWatch(100_000, lambda: count[0])
    watch.begin(0.0)
    count[0] += 9
    assert is_quiet(watch, 0.5)
    count[0] += 1
    with pytest.raises(Overloaded, match="10 malformed frames within a second; allowed: 9"):
        watch.check(1.0)
    assert is_quiet(watch, 1.6)  # nine of them were before the last second
