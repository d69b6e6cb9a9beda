"""Any exception while drives have torque stops them; a wrong answer is a `CanFault`."""

from __future__ import annotations

import struct
from typing import Any

import can
import pytest

from benchmarks.damage.fuzzed_bus import BUS_PHASES, attacks
from handcart.backends.can.bench.bench import Bench
from handcart.backends.can.bus.errors import BrokenOff, CanFault, NodeRestarted, SilentDrive, WrongDrive
from handcart.backends.can.can_backend import CanBackend
from handcart.backends.can.drives.axes import Axes
from handcart.backends.can.simulated.drive_node import DriveNode
from handcart.backends.capabilities.base import Base
from handcart.backends.description.robot_file import RobotFile

from .conftest import LEFT, Make
from .faulty import assert_stopped, move


def states(backend: Any) -> set[str]:
    return {drive.life.state for drive in backend.bench.drives.values()}


@pytest.mark.parametrize("state", [0x77, 0x54, 0x01])
def test_early_heartbeat_of_an_unknown_state_is_ignored(make: Make, state: int) -> None:
    """C16 C20: it says nothing; the drives are enabled, driven, and stopped as ever."""
    backend = make(room=False)
    backend.bench.line.send_message(0x700 + LEFT, bytes([state]))
    move(backend, 5)
    assert states(backend) == {"OPERATION ENABLED"}
    backend.close()
    assert states(backend) == {"SWITCH ON DISABLED"}


def test_drive_booting_before_the_first_step_gets_no_torque(make: Make) -> None:
    """C16: it has forgotten what it was set to."""
    backend = make(room=False)
    backend.bench.drives[LEFT].boot()
    with pytest.raises(NodeRestarted, match=r"the left wheel drive \(node 1\) has booted"):
        backend.step()
    assert states(backend) == {"SWITCH ON DISABLED"}


def lies(drive: Any, data: bytes) -> None:
    """Make a drive execute SDO requests from now on, but answer with these bytes."""
    drive.sdo.send_response = lambda _: drive.network.send_message(0x580 + drive.number, data)


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"", "an answer of 0 bytes"),
        (b"\x4b", "an answer of 1 bytes"),
        (b"\x80\x41\x60", "an answer of 3 bytes"),
        (b"\x4b\x00\x10\x00\x01\x02\x03", "an answer of 7 bytes"),
        (b"\xff" * 8, "Unexpected response"),
        (b"\x43\x41\x60\x00\x37\x02\x00\x00", "instead"),
        (struct.pack("<BHBI", 0x4F, 0x1000, 0, 1), "Mismatch between expected and actual data size"),
        (struct.pack("<BHBI", 0x41, 0x1000, 0, 2**31), "Unexpected"),
    ],
)
@pytest.mark.parametrize("when", ["set-up", "enabling"])
def test_sdo_answers_that_are_none_are_told(
    make: Make, monkeypatch: pytest.MonkeyPatch, data: bytes, message: str, when: str
) -> None:
    """C14 C20: of any length, about another object; no drive stays enabled."""
    if when == "set-up":
        plain = DriveNode.associate_network

        def associate(self: DriveNode, network: Any) -> None:
            plain(self, network)
            lies(self, data)

        monkeypatch.setattr(DriveNode, "associate_network", associate)
        with pytest.raises(WrongDrive, match=message):
            make(room=False)
        return
    backend = make(room=False)
    drive = backend.bench.drives[LEFT + 1]
    plain = drive.life.control

    def control(word: int) -> None:
        plain(word)
        if word == 0x0F:
            lies(drive, data)

    drive.life.control = control
    with pytest.raises(WrongDrive, match=r"its answer about 604[01]h"):
        backend.step()
    assert "OPERATION ENABLED" not in states(backend)


def test_an_answer_without_end_is_ended(make: Make, monkeypatch: pytest.MonkeyPatch) -> None:
    """C14: segment after segment."""
    toggle = iter(range(10**6))

    def answer(self: Any, _can_id: int, data: bytearray, _stamp: float) -> None:
        first = data[0] >> 5 == 2
        command = 0x41 if first else next(toggle) % 2 << 4
        said = struct.pack("<BHBI", 0x41, 0x1000, 0, 2**31) if first else bytes([command]) + b"\x01" * 7
        self.network.send_message(0x580 + self.number, said)

    plain = DriveNode.associate_network

    def associate(self: DriveNode, network: Any) -> None:
        plain(self, network)
        network.unsubscribe(0x600 + self.number)
        network.subscribe(0x600 + self.number, answer.__get__(self))

    monkeypatch.setattr(DriveNode, "associate_network", associate)
    with pytest.raises(WrongDrive, match="an answer of more than 16 frames"):
        make(room=False)
    assert next(toggle) < 100


def test_a_mapping_that_is_refused_is_told(make: Make, monkeypatch: pytest.MonkeyPatch) -> None:
    """C10: as a fault, not as the library's abort."""
    from canopen.sdo.exceptions import SdoAbortedError

    plain = DriveNode.set_data

    def set_data(
        self: DriveNode, index: int, subindex: int, data: bytes, check_writable: bool = False
    ) -> None:
        if index == 0x1600:
            raise SdoAbortedError(0x06010002)
        plain(self, index, subindex, data, check_writable)

    monkeypatch.setattr(DriveNode, "set_data", set_data)
    with pytest.raises(WrongDrive, match="the mapping of its PDOs is refused: Code 0x06010002"):
        make(room=False)


@pytest.mark.parametrize("error", [MemoryError(), KeyError(119), KeyboardInterrupt()])
def test_whatever_ends_a_period_ends_the_torque(
    make: Make, robot: RobotFile, monkeypatch: pytest.MonkeyPatch, error: BaseException
) -> None:
    """K4 C12: a person's Ctrl-C, a fault in the program: all axes stop for good, each in its own way."""
    backend = make(robot=robot, room=False)
    move(backend, 10)

    def raises() -> None:
        raise error

    monkeypatch.setattr(backend.axes, "end_handshakes", raises)
    with pytest.raises(type(error)):
        move(backend, 1)
    with pytest.raises(BrokenOff, match=f"driving was broken off: {type(error).__name__}") as raised:
        move(backend, 1)
    assert_stopped(backend, raised.value)


def test_whatever_ends_the_enabling_ends_the_torque(
    make: Make, robot: RobotFile, monkeypatch: pytest.MonkeyPatch
) -> None:
    """C12: raised behind the last order to a drive."""
    backend = make(robot=robot, room=False)

    def raises() -> None:
        assert "OPERATION ENABLED" in states(backend)
        raise KeyError(119)

    monkeypatch.setattr(backend.axes["gripper"], "start", raises)
    with pytest.raises(KeyError):
        backend.step()
    assert states(backend) == {"SWITCH ON DISABLED", "QUICK STOP ACTIVE"}
    with pytest.raises(BrokenOff):
        backend.step()


@pytest.mark.parametrize("node", [LEFT, 21])
def test_one_drive_that_cant_be_told_doesnt_keep_the_others_enabled(
    make: Make, robot: RobotFile, node: int
) -> None:
    """C12 C22: of a stop, each part is tried, whatever the one before it raised."""
    backend = make(robot=robot, room=False)
    move(backend, 10)
    send = backend.bench.master.send

    def refuses(frame: can.Message, timeout: float | None = None) -> None:
        if frame.arbitration_id in (0x200 + node, 0x080, 0x000):
            raise can.CanOperationError("it has no room")
        send(frame, timeout)

    backend.bench.master.send = refuses
    with pytest.raises(CanFault, match="it has no room"):
        move(backend, 1)
    backend.bench.serve()
    others = [drive for drive in backend.bench.drives.values() if drive.number != node]
    assert "OPERATION ENABLED" not in {drive.life.state for drive in others}
    backend.bench.tick(0.5)
    assert states(backend) == {"SWITCH ON DISABLED", "QUICK STOP ACTIVE"}  # that one by itself


def test_a_stop_that_fails_stops_for_good(make: Make) -> None:
    """C2 C12: the interface fails while the robot is stopped."""
    backend = make(room=False)
    move(backend, 10)
    plain, calls = backend.bench.master.send, []

    def fails(frame: can.Message, timeout: float | None = None) -> None:
        calls.append(frame)
        if len(calls) == 1:
            raise can.CanOperationError("bus off")
        plain(frame, timeout)

    backend.bench.master.send = fails
    with pytest.raises(CanFault, match="while stopping: bus off") as raised:
        backend.stop()
    assert_stopped(backend, raised.value)


def test_sensors_and_bus_are_let_go_of_even_if_the_stop_raises(
    make: Make, monkeypatch: pytest.MonkeyPatch
) -> None:
    backend = make(room=False)
    move(backend, 2)

    def raises() -> None:
        raise KeyError(119)

    monkeypatch.setattr(backend.axes, "quick_stop", raises)
    with pytest.raises(KeyError):
        backend.close()
    assert states(backend) == {"SWITCH ON DISABLED"}  # the next part of the stop was done nevertheless


def test_a_silent_drive_costs_the_others_no_torque(make: Make, monkeypatch: pytest.MonkeyPatch) -> None:
    """C14: it answers no SDO while it is enabled; none of the others stays enabled."""
    backend = make(room=False)
    drive = backend.bench.drives[LEFT + 1]
    backend.bench.line.unsubscribe(0x600 + drive.number)
    with pytest.raises(SilentDrive):
        backend.step()
    assert states(backend) == {"SWITCH ON DISABLED"}


def test_noisy_bus_raises_only_can_faults_and_drops_torque() -> None:
    """C12 C20 C21: frames of all kinds in all phases; more: `python -m benchmarks.hostile.can_fuzz`."""
    seen = list(attacks(len(BUS_PHASES), 500, seed=3))
    assert [attack.wrong for attack in seen] == [""] * len(seen)
    assert {attack.phase for attack in seen} == set(BUS_PHASES)
    assert sum(attack.frames for attack in seen) >= 500
    assert {bool(attack.fault) for attack in seen} == {True, False}


def test_the_same_noise_again() -> None:
    first, second = (list(attacks(2, 0, seed=5)) for _ in range(2))
    assert first == second


def test_noise_finds_what_is_wrong(monkeypatch: pytest.MonkeyPatch) -> None:
    """The fuzzer itself finds a stop that leaves the torque, and an error that is not a `CanFault`."""
    for kind, name in ((Axes, "quick_stop"), (Axes, "disable"), (CanBackend, "_brake")):
        monkeypatch.setattr(kind, name, lambda self: None)
    assert any("OPERATION ENABLED after the fault" in attack.wrong for attack in attacks(4, 0))
    monkeypatch.setattr(Bench, "serve", lambda self: [][0])
    assert all("IndexError" in attack.wrong for attack in attacks(2, 0))


def test_a_robot_drives_on_in_a_little_noise(make: Make) -> None:
    """C20: frames that are not CANopen frames of ours, below the limit, are dropped and counted."""
    backend = make(room=False)
    for number in range(20):
        backend.get(Base).drive(0.2, 0.0)
        backend.step()
        if number % 4 == 0:
            backend.bench.line.send_message(0x333, b"\x01\x02")
            backend.bench.line.send_message(0x181, b"\x01", remote=True)
    assert backend.get(Base).wheel_travel().left > 0.1
    assert backend._line.malformed == 5
