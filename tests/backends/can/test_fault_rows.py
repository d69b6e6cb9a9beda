"""Faults under way, each by the row of docs/faults.md: all axes stop, each in its own way, and stay so."""

from __future__ import annotations

import can
import numpy as np
import pytest

from backends.arm import Arm
from backends.base import Base
from backends.can.errors import (
    BusFault,
    CanFault,
    ControllerFault,
    DriveNotReady,
    Emergency,
    LateLoop,
    LostAnswers,
    NodeRestarted,
    OffDemand,
    Overloaded,
    QueueFull,
    SilentDrive,
    Stranger,
    TwoNodes,
)
from backends.can.simulated.misbehaviours import MISBEHAVIOURS
from backends.robot_file import load_robot

JOINT_1, GRIPPER = 11, 21
BEFORE = 10  # periods driven before something goes wrong
HOLDING, LOOSE = ("QUICK STOP ACTIVE",), ("SWITCH ON DISABLED", "FAULT")


@pytest.fixture
def robot():
    return load_robot("librarian")


def move(backend, periods):
    """Drive, and turn the arm."""
    for _ in range(periods):
        backend.get(Base).drive(0.4, 0.3)
        arm = backend.get(Arm)
        if arm is not None:
            arm.move(arm.command() + np.array([0.02, 0.0, 0.0, 0.0, 0.0, 0.0]))
        backend.step()


def fault_of(backend, name, node=None, within=20):
    """What a misbehaviour under way ends in."""
    move(backend, BEFORE)
    backend.bench.misbehave(name, backend.bench.time, node)
    with pytest.raises(CanFault) as told:
        move(backend, within)
    return told.value


def assert_stopped(backend, fault, gone=()):
    """All axes, each in its own way, for good; drives that are `gone` are not asked for."""
    drives = {node: drive for node, drive in backend.bench.drives.items() if node not in gone}
    assert [drive.velocity for drive in drives.values()] == [0.0] * len(drives)
    for axis in backend.axes.values():
        if axis.id not in gone:
            states = HOLDING if axis.spec.stop == "hold" else LOOSE
            assert drives[axis.id].life.state in (*states, "FAULT")
    there, epoch = [drive.position for drive in drives.values()], backend.epoch
    with pytest.raises(CanFault) as again:
        move(backend, 1)
    assert again.value is fault
    backend.stop()
    assert backend.epoch == epoch + 1
    for _ in range(40):  # nothing that was queued comes after
        backend.bench.serve()
        backend.bench.tick(0.05)
    assert [drive.position for drive in drives.values()] == there
    backend.close()


@pytest.mark.parametrize(
    ("name", "kind", "told"),
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
def test_a_fault_on_the_bus_stops_all_axes_in_words(make, robot, name, kind, told):
    """B6 B7 C3 C4 C7 C11 C12 C13 C15 C16 C17 C18 C19 C20 C22 S1 S2 S4 S6 S9: one fault, all axes stop."""
    backend = make(robot=robot, room=False)
    fault = fault_of(backend, name)
    assert isinstance(fault, kind)
    assert_told(told, fault)
    gone = {1} if name in ("reboot", "stranger", "replay", "silent") else ()
    gone = set(backend.bench.drives) if name == "e-stop" else gone
    assert_stopped(backend, fault, gone)


def assert_told(pattern, fault):
    import re

    assert re.search(pattern, str(fault)), str(fault)


@pytest.mark.parametrize("name", MISBEHAVIOURS)
def test_every_misbehaviour_says_what_it_is(name):
    each = MISBEHAVIOURS[name]
    assert each.what
    assert each.rows


@pytest.mark.parametrize("name", ["stuck", "reversed", "doubled", "late", "silent", "no-heartbeat", "jump"])
def test_the_same_with_a_joint(make, robot, name):
    """B6 B7 B8 C7 C13 S4 C22: an arm's drive stops the wheels, too."""
    backend = make(robot=robot, room=False)
    fault = fault_of(backend, name, JOINT_1, within=30)
    assert "the joint 1 drive (node 11)" in str(fault)
    assert_stopped(backend, fault, {JOINT_1} if name == "silent" else ())


def test_two_periods_of_lateness_are_tolerated_and_more_are_not(make, robot):
    """B8: commands that act one or two periods late."""
    for late in (1, 2):
        backend = make(robot=robot, room=False)
        for drive in backend.bench.drives.values():
            drive.wrong.late = late
        move(backend, 30)
    assert_told("away from where it should be", fault_of(make(robot=robot, room=False), "late", JOINT_1))


def test_an_interface_that_goes_down_leaves_the_drives_to_stop_by_themselves(make, robot):
    """C2: our heartbeat is missing, so they stop by 6007h within 150 ms and their ramp."""
    backend = make(robot=robot, room=False)
    fault = fault_of(backend, "bus-down")
    assert isinstance(fault, BusFault)
    assert "Network is down" in str(fault)
    assert_drives_stop_alone(backend)


def assert_drives_stop_alone(backend, within=0.15):
    moving = [drive.velocity for drive in backend.bench.drives.values()]
    assert any(moving)
    braking = backend.axes["left wheel"].limits
    ramp = braking.speed / braking.braking
    periods = round((within + ramp) / backend.period) + 1
    for _ in range(periods):
        backend.bench.tick(backend.period)
    assert [drive.velocity for drive in backend.bench.drives.values()] == [0.0] * len(moving)
    states = {backend.bench.drives[axis.id].life.state for axis in backend.axes.values()}
    assert states == {"QUICK STOP ACTIVE", "SWITCH ON DISABLED"}


def test_a_warning_of_the_controller_is_waited_out_for_a_second(make, robot):
    """C3: at warning for 1 s."""
    backend = make(robot=robot, room=False)
    start = backend.bench.time
    fault = fault_of(backend, "error-warning", within=40)
    assert_told("in warning for 1 s", fault)
    assert backend.bench.time - start > 1.0


def test_what_the_interface_says_of_itself_is_heard(make, robot):
    """C3 C4: interfaces without error frames."""
    for state, told in ((can.BusState.PASSIVE, "error-passive"), (can.BusState.ERROR, "bus-off")):
        backend = make(robot=robot, room=False)
        move(backend, 2)
        backend.bench.master.condition = state
        with pytest.raises(ControllerFault, match=told):
            move(backend, 1)


def test_one_frame_that_finds_no_room_is_lost_and_three_stop_the_robot(make, robot):
    """C5: as lost set-points."""
    backend = make(robot=robot, room=False)
    move(backend, BEFORE)
    send, refused = backend.bench.master.send, []

    def once(frame, timeout=None):
        if frame.arbitration_id == 0x201 and not refused:
            refused.append(frame)
            raise can.CanOperationError("Transmit buffer full")
        send(frame, timeout)

    backend.bench.master.send = once
    move(backend, BEFORE)
    assert refused
    fault = fault_of(backend, "queue-full")
    assert isinstance(fault, QueueFull)
    assert "3 frames in a row" in str(fault)


def test_what_was_queued_moves_nothing_when_the_cable_is_back(make, robot):
    """C6: what the interface still holds is thrown away; where it can't, the drives don't take it."""
    for flushes in (True, False):
        backend = make(robot=robot, room=False)
        move(backend, BEFORE)
        bus, drives = backend.bench.master, backend.bench.drives
        bus.holds = True
        if not flushes:
            bus.flush_tx_buffer = lambda: None
        with pytest.raises(SilentDrive) as told:
            move(backend, 10)
        for _ in range(60):
            backend.bench.tick(0.05)  # the drives miss our heartbeat meanwhile
        there = [drive.position for drive in drives.values()]
        assert not flushes or not any(frame.data[:1] == b"\x0f" for frame in bus.held)
        bus.plug_in()
        for _ in range(20):
            backend.bench.serve()
            backend.bench.tick(0.05)
        assert [drive.position for drive in drives.values()] == there
        with pytest.raises(CanFault) as again:
            backend.step()
        assert again.value is told.value


def test_a_loop_that_hangs_is_silent_and_the_drives_stop(make, robot):
    """C8 K4 K14: the heartbeat is sent by the loop; when it hangs, or is killed, the drives stop alone."""
    backend = make(robot=robot, room=False)
    move(backend, 20)
    assert_drives_stop_alone(backend)
    with pytest.raises(CanFault):  # and when it wakes up, it gives up
        move(backend, 1)


@pytest.mark.parametrize(
    ("keeps", "told"),
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
def test_a_drive_that_is_not_set_as_it_should_be_gets_no_torque(make, robot, monkeypatch, keeps, told):
    """C9 C10: object, wanted, got; read back before anything is enabled."""
    from backends.can.errors import ReadBackDiffers
    from backends.can.simulated.bench import Bench

    made = []
    plain = Bench.open

    def opened(self):
        made.append(self)
        for drive in self.drives.values():
            drive.wrong.keeps = keeps
        return plain(self)

    monkeypatch.setattr(Bench, "open", opened)
    with pytest.raises(ReadBackDiffers, match=told):
        make(robot=robot, room=False)
    assert {drive.life.state for drive in made[0].drives.values()} == {"SWITCH ON DISABLED"}


def test_emergencies_that_the_file_allows_stop_nothing(make, robot):
    """C11: an allow-list."""
    spec = robot.can.model_copy(update={"allowed_emergencies": (0x4310,)})
    backend = make(robot=robot.model_copy(update={"can": spec}), room=False)
    move(backend, BEFORE)
    backend.bench.misbehave("emergency", backend.bench.time)
    move(backend, BEFORE)


def test_a_drive_is_asked_once_more_and_not_under_way(make, robot):
    """C14: one retry at rest; in motion there are no SDOs that could time out."""
    backend = make(robot=robot, room=False)
    line, sent = backend._line, []
    line.listen(lambda frame, ours: sent.append(frame.arbitration_id) if ours else None)
    move(backend, BEFORE)
    enabling = [each for each in sent if 0x600 < each < 0x680]
    assert enabling
    del sent[:]
    backend.bench.misbehave("no-sdo", backend.bench.time)
    move(backend, BEFORE)
    assert not [each for each in sent if 0x600 < each < 0x680]


def test_random_frames_raise_nothing_but_a_count(make, robot):
    """C20 C21: the decoder takes anything; what a listener raises doesn't deafen the robot."""
    backend = make(robot=robot, room=False)
    move(backend, 1)
    rng = np.random.default_rng(8)
    line = backend._line
    kinds = rng.integers(0, 40, 20_000)
    for kind, can_id, length, data in zip(
        kinds,
        rng.integers(0, 0x800, 20_000),
        rng.integers(0, 9, 20_000),
        rng.integers(0, 256, (20_000, 8), dtype=np.uint8),
        strict=True,
    ):
        line._take(
            can.Message(
                arbitration_id=int(can_id),
                data=None if kind == 0 else data[:length].tobytes(),
                is_remote_frame=kind == 0,
                is_error_frame=kind == 1,
                is_extended_id=kind == 2,
                is_fd=kind == 3,
            )
        )
    assert line.malformed > 100
    with pytest.raises(CanFault):
        move(backend, 1)


def test_a_listener_that_raises_is_counted_and_the_next_frame_is_heard(make, robot):
    """C21: there is no receive thread that could die."""
    backend = make(robot=robot, room=False)
    move(backend, 1)

    def raises(*_):
        raise RuntimeError("a listener")

    backend._line.subscribe(0x181, raises)
    move(backend, 2)
    assert backend._line.malformed == 2
    with pytest.raises(Overloaded, match="malformed"):
        move(backend, 10)


def test_a_late_loop_ramps_to_a_stop(make, robot):
    """K6 K7 K9: three periods missed in a row, or one gap of 50 ms."""

    class Late:
        trouble = ""

        def wait(self):
            return

        def begin(self):
            return

    backend = make(robot=robot, room=False)
    move(backend, BEFORE)
    backend._pace = Late()
    move(backend, 2)
    backend._pace.trouble = "a period ended 63 ms late; allowed: 50 ms"
    with pytest.raises(LateLoop, match="the control loop is too slow: a period ended 63 ms late") as told:
        move(backend, 1)
    assert_stopped(backend, told.value)


def test_wall_clocks_are_not_asked(make, robot, monkeypatch):
    """K8 B9: a clock that jumps by an hour changes nothing; on a bench no clock is read."""
    import time

    moments = iter(range(0, 10**9, 3600))
    for name in ("time", "monotonic"):
        monkeypatch.setattr(time, name, lambda: float(next(moments)))
    backend = make(robot=robot, room=False)
    move(backend, 20)
    assert backend.get(Base).wheel_travel().left > 0.1


def test_a_joint_beyond_its_limits_at_the_start_is_refused(make, robot):
    """S3 S9: an encoder that has lost its reference."""
    from backends.can.errors import WrongDrive

    backend = make(robot=robot, room=False)
    drive = backend.bench.drives[13]
    drive.stand_at(-0.2 * backend.axes["joint 3"].units.scale)
    with pytest.raises(WrongDrive, match="somebody has moved it"):
        move(backend, 1)
    assert drive.life.state == "SWITCH ON DISABLED"


def test_a_single_jump_is_not_taken_over(make, robot):
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


def test_a_lost_answer_is_tolerated(make, robot):
    """S5 S6: up to 5 of 100; what comes late belongs to an earlier SYNC."""
    backend = make(robot=robot, room=False)
    backend.bench.drives[JOINT_1].wrong.drops = 0.04
    for _ in range(130):
        backend.get(Base).drive(0.1, 0.0)
        backend.step()
    assert backend.get(Base).wheel_travel().left > 0.5
