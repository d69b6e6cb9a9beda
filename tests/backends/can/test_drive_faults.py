"""Faults of drives, by the rows of docs/reference/faults.md: all axes stop and stay stopped."""

from __future__ import annotations

import pytest

from handcart.backends.can.bench.bench import Bench
from handcart.backends.can.bench.bench_bus import BenchBus
from handcart.backends.can.bench.injected_faults import INJECTED_FAULTS, inject
from handcart.backends.can.bus.errors import (
    CanFault,
    ControllerFault,
    DriveNotReady,
    Emergency,
    LostAnswers,
    NodeRestarted,
    OffDemand,
    Overloaded,
    ReadBackDiffers,
    SilentDrive,
    Stranger,
    TwoNodes,
    WrongDrive,
)
from handcart.backends.capabilities.base import Base
from handcart.backends.description.robot_file import RobotFile

from .conftest import Make
from .faulty import BEFORE, JOINT_1, assert_stopped, assert_told, fault_of, move


@pytest.mark.parametrize(
    ("name", "kind", "message"),
    [
        ("error-passive", ControllerFault, "error-passive"),
        ("bus-off", ControllerFault, r"off the bus \(bus-off\)"),
        ("no-heartbeat", SilentDrive, r"no heartbeat \(700h\) for 0\.2 s"),
        ("emergency", Emergency, "error 4310h, excess temperature of the drive"),
        ("fault", Emergency, "error 2310h, continuous over-current"),
        ("disabled", DriveNotReady, "SWITCH ON DISABLED; needed: OPERATION ENABLED"),
        ("silent", SilentDrive, r"no statusword and position \(6041h, 6064h\) .* for 0\.1 s"),
        ("two-nodes", TwoNodes, "two answers to one SYNC"),
        ("collision", TwoNodes, r"8150h"),
        ("reboot", NodeRestarted, "has booted under way"),
        ("stranger", Stranger, r"000h \[81 01\]"),
        ("stranger-command", Stranger, r"201h \[0f 00"),
        ("replay", OffDemand, "away from where it should be"),
        ("flood", Overloaded, r"% for 0\.1 s; allowed: 70 %"),
        ("short-answers", (Overloaded, SilentDrive), "malformed|silent"),
        ("remote-frames", Overloaded, "20 malformed frames within a second; allowed: 9"),
        ("stuck", OffDemand, "away from where it should be"),
        ("reversed", OffDemand, "away from where it should be"),
        ("doubled", OffDemand, "away from where it should be"),
        ("jump", OffDemand, "jumps"),
        ("drops", LostAnswers, "is unreliable: 6 of .* answers didn't come; allowed: 5 of 100"),
        ("e-stop", DriveNotReady, "SWITCH ON DISABLED"),
    ],
)
def test_a_fault_on_the_bus_stops_all_axes_in_words(
    make: Make, robot: RobotFile, name: str, kind: type[CanFault] | tuple[type[CanFault], ...], message: str
) -> None:
    """B6 B7 C3 C4 C7 C11 C12 C13 C15 C16 C17 C18 C19 C20 C22 S1 S2 S4 S6 S9: one fault, all axes stop."""
    backend = make(robot=robot, room=False)
    fault = fault_of(backend, name)
    assert isinstance(fault, kind)
    assert_told(message, fault)
    gone = {1} if name in ("reboot", "stranger", "replay", "silent") else ()
    gone = set(backend.bench.drives) if name == "e-stop" else gone
    assert_stopped(backend, fault, gone)


@pytest.mark.parametrize("name", INJECTED_FAULTS)
def test_every_injected_fault_says_what_it_is(name: str) -> None:
    each = INJECTED_FAULTS[name]
    assert each.what
    assert each.rows


@pytest.mark.parametrize("name", ["stuck", "reversed", "doubled", "late", "silent", "no-heartbeat", "jump"])
def test_the_same_with_a_joint(make: Make, robot: RobotFile, name: str) -> None:
    """B6 B7 B8 C7 C13 S4 C22: an arm's drive stops the wheels, too."""
    backend = make(robot=robot, room=False)
    fault = fault_of(backend, name, JOINT_1, within=30)
    assert "the joint 1 drive (node 11)" in str(fault)
    assert_stopped(backend, fault, {JOINT_1} if name == "silent" else ())


@pytest.mark.slow
def test_two_periods_of_lateness_are_tolerated_and_more_are_not(make: Make, robot: RobotFile) -> None:
    """B8: commands that act one or two periods late."""
    for late in (1, 2):
        backend = make(robot=robot, room=False)
        for drive in backend.bench.drives.values():
            drive.wrong.late = late
        move(backend, 30)
        assert min(backend.get(Base).wheel_travel()[:2]) > 0.2
        assert {drive.life.state for drive in backend.bench.drives.values()} == {"OPERATION ENABLED"}
    assert_told("away from where it should be", fault_of(make(robot=robot, room=False), "late", JOINT_1))


@pytest.mark.parametrize(
    ("keeps", "message"),
    [
        ({(0x1016, 1): 0}, r"consumer heartbeat time 1 \(1016h:1\) is 0; wanted: 8323222"),
        ({(0x1017, 0): 0}, r"\(1017h\) is 0; wanted: 50"),
        ({(0x6007, 0): 0}, r"\(6007h\) is 0; wanted: 3"),
        ({(0x605A, 0): 0}, r"\(605Ah\) is 0; wanted: 2"),
        ({(0x605E, 0): 0}, r"\(605Eh\) is 0; wanted: 2"),
        ({(0x1029, 1): 1}, r"\(1029h:1\) is 1; wanted: 0"),
        ({(0x607D, 1): 0}, r"\(607Dh:1\) is 0; wanted: -"),
        ({(0x6065, 0): 0}, r"\(6065h\) is 0; wanted: "),
        ({(0x6066, 0): 0}, r"\(6066h\) is 0; wanted: 100"),
        ({(0x607F, 0): 9}, r"\(607Fh\) is 9; wanted: "),
    ],
)
def test_a_drive_that_is_not_set_as_it_should_be_gets_no_torque(
    make: Make,
    robot: RobotFile,
    monkeypatch: pytest.MonkeyPatch,
    keeps: dict[tuple[int, int], int],
    message: str,
) -> None:
    """C9 C10: object, wanted, got; read back before anything is enabled."""
    made: list[Bench] = []
    plain = Bench.open

    def opened(self: Bench) -> BenchBus:
        made.append(self)
        for drive in self.drives.values():
            drive.wrong.keeps = keeps
        return plain(self)

    monkeypatch.setattr(Bench, "open", opened)
    with pytest.raises(ReadBackDiffers, match=message):
        make(robot=robot, room=False)
    assert {drive.life.state for drive in made[0].drives.values()} == {"SWITCH ON DISABLED"}


def test_emergencies_that_the_file_allows_stop_nothing(make: Make, robot: RobotFile) -> None:
    """C11: an allow-list."""
    assert robot.can is not None
    spec = robot.can.model_copy(update={"allowed_emergencies": (0x4310,)})
    backend = make(robot=robot.model_copy(update={"can": spec}), room=False)
    move(backend, BEFORE)
    before = backend.get(Base).wheel_travel().left
    inject(backend.bench, "emergency", backend.bench.time)
    move(backend, BEFORE)
    assert backend.get(Base).wheel_travel().left > before + 0.1
    assert {drive.life.state for drive in backend.bench.drives.values()} == {"OPERATION ENABLED"}


def test_a_drive_is_asked_once_more_and_not_under_way(make: Make, robot: RobotFile) -> None:
    """C14: one retry at rest; in motion there are no SDOs that could time out."""
    backend = make(robot=robot, room=False)
    line, sent = backend._line, []
    line.listen(lambda frame, ours: sent.append(frame.arbitration_id) if ours else None)
    move(backend, BEFORE)
    enabling = [item for item in sent if 0x600 < item < 0x680]
    assert enabling
    del sent[:]
    inject(backend.bench, "no-sdo", backend.bench.time)
    move(backend, BEFORE)
    assert not [item for item in sent if 0x600 < item < 0x680]


def test_a_joint_beyond_its_limits_at_the_start_is_refused(make: Make, robot: RobotFile) -> None:
    """S3 S9: an encoder that has lost its reference."""
    backend = make(robot=robot, room=False)
    drive = backend.bench.drives[13]
    drive.stand_at(-0.2 * backend.axes["joint 3"].units.scale)
    with pytest.raises(WrongDrive, match="somebody has moved it"):
        move(backend, 1)
    assert drive.life.state == "SWITCH ON DISABLED"


def test_a_single_jump_is_not_taken_over(make: Make, robot: RobotFile) -> None:
    """S3 S4: a position that can't be is rejected once; the next sound one has it all."""
    backend = make(robot=robot, room=False)
    move(backend, BEFORE)
    drive = backend.bench.drives[1]
    before = backend.get(Base).wheel_travel().left
    drive.wrong.jump = 10**7
    move(backend, 1)
    assert backend.get(Base).wheel_travel().left == before
    drive.wrong.jump = 0
    move(backend, 1)
    assert before + 0.02 < backend.get(Base).wheel_travel().left < before + 0.06


@pytest.mark.slow
def test_a_lost_answer_is_tolerated(make: Make, robot: RobotFile) -> None:
    """S5 S6: up to 5 of 100; what comes late belongs to an earlier SYNC."""
    backend = make(robot=robot, room=False)
    backend.bench.drives[JOINT_1].wrong.drops = 0.04
    for _ in range(130):
        backend.get(Base).drive(0.1, 0.0)
        backend.step()
    assert backend.get(Base).wheel_travel().left > 0.5
