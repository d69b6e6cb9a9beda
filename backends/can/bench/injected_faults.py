"""Faults that hardware shows, to be injected on a bench one by one."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import can

from handcart.backends.can.simulated.drive_node import DriveNode, nmt_reset
from handcart.files.errors import InputError
from handcart.files.suggest import suggest

from .bench import Act, Bench


class UnknownFault(InputError):
    """Error: a bench (simulated drives on a CAN bus) has no fault with the requested name."""

    def __init__(self, name: str) -> None:
        super().__init__(f"unknown fault {name!r}{suggest(name, INJECTED_FAULTS)}")


class InjectedFault(NamedTuple):
    """A fault of a drive or of the bus that a bench can cause on request, to test the reaction to it."""

    rows: str
    """Row ids in docs/reference/faults.md."""
    what: str
    """Description of the fault."""
    act: Act
    """Function that causes the fault of a drive or of the bus."""


def injected_fault(name: str) -> InjectedFault:
    """Return the fault with the given name.

    Raises:
        UnknownFault: no fault has this name.
    """
    if name not in INJECTED_FAULTS:
        raise UnknownFault(name)
    return INJECTED_FAULTS[name]


def inject(bench: Bench, name: str, at_s: float = 0.0, node: int | None = None) -> None:
    """Plan a fault of a simulated drive, or of the bus, on a bench.

    Args:
        bench: the bench, which has the simulated drives and the bus.
        name: one of `INJECTED_FAULTS`.
        at_s: time of the bench at which the fault begins, in [s]; if it is past, the fault begins in the next
            period.
        node: node ID of the faulty drive; None: the drive of the first axis.

    Raises:
        UnknownFault: the name is unknown.
    """
    bench.go_wrong_at(at_s, injected_fault(name).act, node)


def _set(**wrong: object) -> Act:
    def act(_: Bench, drive: DriveNode) -> None:
        for name, value in wrong.items():
            setattr(drive.wrong, name, value)

    return act


def _bus(**condition: object) -> Act:
    def act(bench: Bench, _: DriveNode) -> None:
        for name, value in condition.items():
            setattr(bench.master, name, value)

    return act


def _error_frame(kind: int, detail: int) -> Act:
    frame = can.Message(
        is_error_frame=True, arbitration_id=kind, data=[0, detail, 0, 0, 0, 0, 0, 0], is_extended_id=False
    )

    def act(bench: Bench, _: DriveNode) -> None:
        if bench.master is not None:
            bench.master.injected.append(frame)

    return act


def _send(can_id: Callable[[int], int], data: Callable[[int], bytes], times: int = 1) -> Act:
    def act(bench: Bench, drive: DriveNode) -> None:
        for _ in range(times):
            bench.line.send_message(can_id(drive.number), data(drive.number))

    return act


def _replay(bench: Bench, drive: DriveNode) -> None:
    """Send the answers of the present period again in every later one, in place of the drive's own."""
    drive.wrong.frozen = True


def _deaf(bench: Bench, drive: DriveNode) -> None:
    bench.line.unsubscribe(drive.sdo.rx_cobid)


def _press(bench: Bench, _: DriveNode) -> None:
    for drive in bench.drives.values():
        drive.pressed = True


_EMCY_COLLISION = 0x8150

INJECTED_FAULTS: dict[str, InjectedFault] = {
    "bus-down": InjectedFault("C2", "the interface goes down", _bus(down=True)),
    "error-passive": InjectedFault("C3", "the controller becomes error-passive", _error_frame(0x04, 0x20)),
    "error-warning": InjectedFault("C3", "the controller stays in warning", _error_frame(0x04, 0x08)),
    "bus-off": InjectedFault("C4", "the controller goes off the bus", _error_frame(0x40, 0)),
    "queue-full": InjectedFault("C5", "the interface takes no more frames", _bus(full=True)),
    "cable-off": InjectedFault("C6", "frames stay in the interface's queue", _bus(holds=True)),
    "no-heartbeat": InjectedFault("C7", "a drive's heartbeat is missing", _set(no_heartbeat=True)),
    "no-consumer": InjectedFault(
        "C9", "a drive doesn't take its consumer heartbeat time (1016h)", _set(keeps={(0x1016, 1): 0})
    ),
    "no-quick-stop": InjectedFault(
        "C10", "a drive doesn't take its reactions (6007h)", _set(keeps={(0x6007, 0): 0})
    ),
    "emergency": InjectedFault(
        "C11", "a drive sends an emergency message", lambda _, drive: drive.emcy.send(0x4310, 1)
    ),
    "fault": InjectedFault("C12", "a drive has a fault", lambda _, drive: drive.fail(0x2310)),
    "disabled": InjectedFault("C12, C22", "a drive loses its torque", lambda _, drive: drive.life.disable()),
    "silent": InjectedFault("C13", "a drive sends no PDOs any more", _set(silent=True)),
    "no-sdo": InjectedFault("C14", "a drive answers no SDO", _deaf),
    "two-nodes": InjectedFault(
        "C15",
        "another node has the same ID",
        _send(lambda node: 0x180 + node, lambda node: bytes([0x37, 0x06, 0, 0, 0, 0, 3])),
    ),
    "collision": InjectedFault(
        "C15",
        "a drive reports a second node with its ID",
        lambda _, drive: drive.emcy.send(_EMCY_COLLISION, 0x11),
    ),
    "reboot": InjectedFault("C16, S9", "a drive starts anew", lambda _, drive: drive.boot()),
    "stranger": InjectedFault("C17", "another node resets a drive (NMT)", _send(lambda _: 0, nmt_reset)),
    "stranger-command": InjectedFault(
        "C17",
        "another node commands a drive (RPDO)",
        _send(lambda node: 0x200 + node, lambda _: bytes([0x0F, 0, 0, 0, 0, 0])),
    ),
    "replay": InjectedFault("C18, S2", "a drive's old answers are sent again", _replay),
    "flood": InjectedFault(
        "C19", "frames of high priority fill the bus", _send(lambda _: 0x001, lambda _: bytes(8), 1000)
    ),
    "short-answers": InjectedFault("C20", "a drive's answers are too short", _set(short=True)),
    "remote-frames": InjectedFault("C20", "remote requests come", lambda bench, _: _remote(bench, 20)),
    "stuck": InjectedFault("B6", "a motor doesn't turn, and its drive doesn't notice", _set(gain=0.0)),
    "reversed": InjectedFault("B7", "a motor turns the wrong way", _set(gain=-1.0)),
    "doubled": InjectedFault("B7", "a motor turns twice as far", _set(gain=2.0)),
    "late": InjectedFault("B8", "a motor is five periods late", _set(late=5)),
    "jump": InjectedFault("S4", "a drive's position jumps to and fro", _set(jump=10**6, jumps_in_turn=True)),
    "encoder-wrap": InjectedFault("S13", "a drive's encoder wraps after 65536 counts", _set(wraps=2**16)),
    "drops": InjectedFault("S6", "every second answer of a drive is lost", _set(drops=0.5)),
    "e-stop": InjectedFault("C12", "a person presses the emergency stop", _press),
}
"""Faults by the names that `handcart bench --fault` takes."""


def _remote(bench: Bench, times: int) -> None:
    for _ in range(times):
        bench.line.send_message(0x181, b"", remote=True)
