"""Drives as their makers describe them: missing objects are reported, accepted by name, and not used."""

from __future__ import annotations

import re
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from canopen.sdo.exceptions import SdoAbortedError

from handcart.backends.can.bench.bench import Bench
from handcart.backends.can.bench.bench_bus import BenchBus
from handcart.backends.can.bus.errors import Emergency, ReadBackDiffers
from handcart.backends.can.can_backend import CanBackend
from handcart.backends.can.devices.cyclic_frames import cyclic_frames
from handcart.backends.can.eds.lacks import DEVICE_LACKS, not_watched
from handcart.backends.can.simulated.drive_node import DriveNode
from handcart.backends.can.simulated.simulated_drives import SimulatedDrives
from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.base import Base
from handcart.backends.capabilities.gripper import Gripper
from handcart.backends.description.can_spec import Without
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.description.robot_names import SHIPPED_FOLDER
from handcart.backends.kinematic.kinematic_parts import KinematicGripper
from handcart.backends.loading.robot_loading import load_robot
from handcart.evaluation.bringup.bus_rungs import ReadBackRung
from handcart.evaluation.bringup.operator import BenchOperator
from handcart.evaluation.bringup.site import Site
from handcart.evaluation.robot_report.report import report_of
from handcart.files.errors import FileError
from tests.backends.can.conftest import LEFT, ROOM, Make
from tests.backends.can.faulty import JOINT_1, fault_of, move

OWN = Path(__file__).resolve().parents[4] / "backends" / "can" / "drives" / "drive.eds"
JOINTS = (11, 12, 13, 14, 15, 16)


def maker_eds(*lacks: int | str) -> str:
    """Our own file without some objects, as makers' are: `6066` or `1400sub5`."""
    text = OWN.read_text(encoding="utf-8")
    for item in lacks:
        name = item if isinstance(item, str) else f"{item:04X}"
        sections = name if "sub" in name else rf"{name}(?:sub\d+)?"
        text = re.sub(rf"(?ims)^\[(?:{sections})\]\n.*?(?=^\[|\Z)", "", text)
    return text


def written(folder: Path, eds: str, nodes: tuple[int, ...], more: str = "") -> str:
    """The librarian's file with that EDS for some of its drives."""
    robot = Path(shutil.copytree(SHIPPED_FOLDER / "librarian", folder / "librarian"))
    (robot / "maker.eds").write_text(eds, encoding="utf-8")
    path = robot / "robot.yaml"
    text = path.read_text(encoding="utf-8")
    for node in nodes:
        assert f"{{node: {node}," in text
        text = text.replace(f"{{node: {node},", f"{{node: {node}, eds: maker.eds, {more}")
    path.write_text(text, encoding="utf-8")
    return str(path)


def without(*words: str, brake: bool = False) -> str:
    return f"without: [{', '.join(words)}], " + ("brake: true, " if brake else "")


LEFT_OUT = {word: lack.objects for word, lack in DEVICE_LACKS.items()}


@pytest.mark.parametrize("word", DEVICE_LACKS)
def test_what_a_drive_lacks_is_told_until_it_is_accepted(tmp_path: Path, word: Without) -> None:
    """C9 C10: at the drive's place in the robot's file, with what follows, and how that is accepted."""
    eds, brake = maker_eds(*LEFT_OUT[word]), "brake: true, "
    with pytest.raises(FileError) as error:
        load_robot(written(tmp_path / "asked", eds, (JOINT_1,), brake))
    (finding,) = error.value.findings
    assert finding.file.endswith("robot.yaml")
    assert finding.line > 1
    lack = DEVICE_LACKS[word]
    assert f"maker.eds describes no {lack.objects[0]:04X}h" in finding.message
    assert lack.then in finding.message
    assert finding.message.endswith(f"to accept that: without: [{word}]")
    accepted = load_robot(written(tmp_path / "accepted", eds, (JOINT_1,), without(word, brake=True)))
    assert accepted.can is not None
    assert not_watched(accepted.can.joints[0]) == [f"without {lack.what}: {lack.then}"]


def test_accepting_one_thing_accepts_no_other(tmp_path: Path) -> None:
    """C9 C10: each by its name."""
    eds = maker_eds(0x1016, 0x603F, 0x6077)
    with pytest.raises(FileError) as error:
        load_robot(written(tmp_path, eds, (LEFT,), without("error_code")))
    lacking = [finding.message.rpartition("without: ")[2] for finding in error.value.findings]
    assert sorted(lacking) == ["[consumer_heartbeat]", "[torque]"]


def test_what_nobody_can_do_without_is_told_in_the_eds_file(tmp_path: Path) -> None:
    """C10: a mode that it can't be commanded in, no producer heartbeat."""
    with pytest.raises(FileError) as error:
        load_robot(written(tmp_path, maker_eds(0x60FF, 0x1017), (LEFT,)))
    (finding,) = error.value.findings
    assert finding.file.endswith("maker.eds")
    assert "no 1017h (producer heartbeat time), no 60FFh (for a PDO); needed" in finding.message


def test_an_axis_that_may_fall_at_a_stop_is_refused(tmp_path: Path) -> None:
    """C10: gravity, no brake, and it is unknown whether a quick stop keeps its torque."""
    with pytest.raises(FileError, match=r"may fall at a stop without: .quick_stop_option.; allowed"):
        load_robot(written(tmp_path, maker_eds(0x605A), (JOINT_1,), without("quick_stop_option")))


ALL = tuple(index for lack in DEVICE_LACKS.values() for index in lack.objects)
SILENT = (0x1006, 0x1029, "1400sub5", 0x6080, 0x6084)
"""Objects that may be missing without being accepted."""


@pytest.fixture
def bare(tmp_path: Path, make: Make) -> Any:
    """A robot all of whose drives lack all that can be lacked."""
    eds = maker_eds(*ALL, *SILENT)
    accepted = without(*DEVICE_LACKS, brake=True)
    robot = load_robot(written(tmp_path, eds, (1, 2, *JOINTS, 21), accepted))
    return make(robot=robot, room=False)


def test_drives_are_used_with_what_they_have(bare: Any) -> None:
    """C9 C10: nothing that isn't there is written, read, or mapped; they are driven, and stopped."""
    move(bare, 30)
    assert bare.get(Base).wheel_travel().left > 0.3
    assert bare.get(Arm).joints()[0] == pytest.approx(0.6, abs=0.03)
    assert bare.get(Arm).hand_force() == pytest.approx(np.zeros(3))
    length = {frame.cob_id: frame.length for frame in cyclic_frames(bare._spec, 0.05)}
    assert length[0x280 + LEFT] == 4  # velocity alone
    bare.close()
    drives = bare.bench.drives.values()
    assert "OPERATION ENABLED" not in {drive.life.state for drive in drives}
    assert [drive.velocity for drive in drives] == [0.0] * len(drives)


def test_faults_of_such_drives_stop_the_robot(bare: Any) -> None:
    """C11 C12: reported by their emergency message."""
    fault = fault_of(bare, "fault", JOINT_1)
    assert isinstance(fault, Emergency)
    assert "error 2310h, continuous over-current" in str(fault)
    assert "OPERATION ENABLED" not in {drive.life.state for drive in bare.bench.drives.values()}


def test_what_follows_is_true(bare: Any) -> None:
    """C7 C8: without 1016h and 1400h:5 a drive keeps running when this program is gone."""
    move(bare, 20)
    drive = bare.bench.drives[LEFT]
    for _ in range(40):
        bare.bench.tick(0.05)
    assert drive.life.state == "OPERATION ENABLED"
    assert drive.velocity != 0.0


def test_a_force_is_felt_by_the_joints_that_tell_their_torque(make: Make, robot: RobotFile) -> None:
    assert robot.can is not None
    joints = [joint.model_copy(update={"without": ("torque",)}) for joint in robot.can.joints]
    some = (*joints[:1], *robot.can.joints[1:])
    for drives, felt in ((some, True), (tuple(joints), False)):
        spec = robot.can.model_copy(update={"joints": drives})
        backend = make(robot=robot.without_errors().model_copy(update={"can": spec}))
        backend.step()
        for _ in range(2):
            backend.inner.scene.hand_force = np.array([-20.0, 0.0, 8.0])
            backend.bench.inner._arm._settled = True  # a gripper in contact does not move
            backend.step()
        force = backend.get(Arm).hand_force()
        assert bool(np.linalg.norm(force) > 5.0) is felt


def test_fingers_without_torque_press_by_their_position_error(
    make: Make, robot: RobotFile, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert robot.can is not None and robot.can.gripper is not None
    gripper_spec = robot.can.gripper.model_copy(update={"without": ("torque",)})
    spec = robot.can.model_copy(update={"gripper": gripper_spec})
    backend = make(robot=robot.model_copy(update={"can": spec}))
    gripper, seen = backend.get(Gripper), []

    def close(width: float) -> None:
        gripper.move(width)
        for _ in range(40):
            backend.step()
            seen.append(gripper.closed_on_something())

    close(0.03)
    assert not any(seen)
    blocked = KinematicGripper.width
    monkeypatch.setattr(KinematicGripper, "width", lambda self: max(0.02, blocked(self)))
    close(0.0)
    assert gripper.closed_on_something()
    assert gripper.width() == pytest.approx(0.02, abs=1e-4)
    gripper.halt()
    assert gripper.command() == 0.0  # pressing fingers keep pressing


def test_real_drive_lacking_a_feature_names_the_key_to_accept_it(
    make: Make, monkeypatch: pytest.MonkeyPatch
) -> None:
    """C9 C10: at the read-back, before anything has torque."""
    plain = Bench.open

    def opened(self: Bench) -> BenchBus:
        drive: Any = self.drives[LEFT]
        described = drive.objects.described
        drive.objects.described = lambda index, sub=0: index not in (0x1016, 0x605A) and described(index, sub)
        return plain(self)

    monkeypatch.setattr(Bench, "open", opened)
    with pytest.raises(ReadBackDiffers) as error:
        make(room=False)
    first, second = str(error.value).splitlines()
    assert first.endswith("wanted: 8323222")
    assert "(1016h:1) is refused: Code 0x06090011" in first
    assert (
        f"if it has none: {DEVICE_LACKS['consumer_heartbeat'].then}; to accept that: without: [consumer"
        in first
    )
    assert "without: [quick_stop_option]" in second


def test_check_and_bring_up_say_what_is_not_watched(tmp_path: Path) -> None:
    robot = load_robot(written(tmp_path, maker_eds(0x1016), (LEFT,), without("consumer_heartbeat")))
    words = f"left wheel: without consumer heartbeat time: {DEVICE_LACKS['consumer_heartbeat'].then}"
    assert words in report_of(robot, tried=False).warnings
    said: list[str] = []
    site = Site(
        "librarian", robot, BenchOperator(said.append), tmp_path, tmp_path, "kinematic", world(tmp_path)
    )
    facts: Any = ReadBackRung().climb(site)
    assert words in said
    assert list(facts["accepted"]) == ["left wheel"]
    assert "1016h:1" not in facts["supervision"]["left wheel"]
    assert facts["supervision"]["right wheel"]["1016h:1"] > 0


def world(folder: Path) -> Path:
    path = folder / "world.yaml"
    walls = "\n".join(f"  - {{from_m: {wall['from_m']}, to_m: {wall['to_m']}}}" for wall in ROOM["walls"])
    start = ", ".join(f"{key}: {value}" for key, value in ROOM["start"].items())
    path.write_text(f"format: handcart-world/1\nstart: {{{start}}}\nwalls:\n{walls}\n", encoding="utf-8")
    return path


@pytest.fixture
def lone() -> Iterator[DriveNode]:
    drives = SimulatedDrives([5], 0.01)
    yield drives.nodes[5]
    drives.close()


@pytest.mark.parametrize(
    ("index", "subindex", "code"),
    [
        (0x6040, 1, 0x06090011),
        (0x6041, 255, 0x06090011),
        (0x1018, 9, 0x06090011),
        (0x5FFF, 0, 0x06020000),
        (0x5FFF, 3, 0x06020000),
    ],
)
def test_a_simulated_drive_aborts_what_it_does_not_have(
    lone: DriveNode, index: int, subindex: int, code: int
) -> None:
    """C14: variables have no sub-index but 0."""
    for ask in (
        lambda: lone.get_data(index, subindex),
        lambda: lone.set_data(index, subindex, b"\x06\x00"),
    ):
        with pytest.raises(SdoAbortedError) as abort:
            ask()
        assert abort.value.code == code
    assert lone.life.state == "SWITCH ON DISABLED"


def test_a_simulated_drive_refuses_modes_that_it_lacks(lone: DriveNode) -> None:
    """C10: by 6502h; it stays in the mode that it has."""
    lone.set_data(0x6060, 0, b"\x03")
    for mode in (2, 4, 7, 10, -1):
        with pytest.raises(SdoAbortedError) as abort:
            lone.set_data(0x6060, 0, mode.to_bytes(1, "little", signed=True))
        assert abort.value.code == 0x06090030
    assert lone.get_data(0x6061, 0) == b"\x03"
    assert lone.get_data(0x6060, 0) == b"\x03"


def test_a_maker_whose_drive_has_no_cyclic_mode(tmp_path: Path) -> None:
    """C10: its 6502h says so, on the bench too."""
    eds = maker_eds()
    assert "DefaultValue=0x1A5" in eds
    path = written(tmp_path, eds.replace("DefaultValue=0x1A5", "DefaultValue=0x25"), (LEFT,), "mode: csv, ")
    robot = load_robot(path)
    assert robot.can is not None
    bench = Bench(robot, robot.can, None)
    with pytest.raises(Exception, match=r"supported drive modes \(6502h\) is 0x25; allowed: cyclic"):
        CanBackend(robot, bench)
    bench.close()


def test_a_cob_id_that_is_the_drives_own_is_left_as_it_is(tmp_path: Path, make: Make) -> None:
    """Some drives have theirs read-only: only what is in the PDO is written."""
    text = maker_eds()
    for record in ("1400", "1800", "1801"):
        text = re.sub(rf"(?is)(\[{record}sub1\].*?AccessType=)rw", r"\g<1>ro", text, count=1)
    backend = make(robot=load_robot(written(tmp_path, text, (LEFT,))), room=False)
    assert not backend.axes["left wheel"].rpdo[1].com_record[1].writable
    move(backend, 10)
    assert backend.get(Base).wheel_travel().left > 0.05
