"""Encoders whose counts start over inside the travel of an axis: found, named, never a false position."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from canopen.objectdictionary import ObjectDictionary

from handcart.backends.can.bench.bench import Bench
from handcart.backends.can.bus.errors import EncoderWraps, OffDemand
from handcart.backends.can.can_backend import CanBackend
from handcart.backends.can.drives.position_jumps import encoder_bits
from handcart.backends.can.drives.position_range import PositionRange, described_range
from handcart.backends.can.eds.eds_file import read_eds
from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.base import Base
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.loading.robot_loading import load_robot
from handcart.files.errors import FileError
from tests.backends.can.eds.test_lacks import maker_eds, written

from ..conftest import LEFT
from ..faulty import JOINT_1

RANGE = 0x607B
JOINT_STEP, SPEED = 0.002, 0.1


@pytest.fixture
def bench(robot: RobotFile) -> Iterator[Bench]:
    """The librarian's drives, to be spoilt before they are set up."""
    assert robot.can is not None
    made = Bench(robot, robot.can, None)
    yield made
    made.close()


@pytest.fixture
def open_backend(robot: RobotFile, bench: Bench) -> Iterator[Any]:
    with ExitStack() as opened:
        yield lambda: opened.enter_context(CanBackend(robot, bench))


def moved_until_fault(backend: Any, bench: Bench, node: int, periods: int = 200) -> tuple[float, OffDemand]:
    """Move slowly; return by how much a position was ever false, and the fault."""
    (axis,) = (item for item in backend.axes.values() if item.spec.node == node)
    worst = 0.0
    for _ in range(periods):
        try:
            backend.get(Base).drive(SPEED, 0.0)
            arm = backend.get(Arm)
            arm.move(arm.command() + np.array([JOINT_STEP, 0.0, 0.0, 0.0, 0.0, 0.0]))
            backend.step()
        except OffDemand as fault:
            return worst, fault
        true = bench.drives[node].position / axis.units.scale
        worst = max(worst, abs((axis.position if axis.positioned else axis.travel) - true))
    raise AssertionError("the encoder has wrapped, and nobody noticed")


@pytest.mark.parametrize(("node", "bits"), [(JOINT_1, 16), (JOINT_1, 14), (LEFT, 16), (LEFT, 14)])
def test_encoder_that_wraps_stops_the_robot_and_is_named(
    bench: Bench, open_backend: Any, node: int, bits: int
) -> None:
    """S13: also where the wrap is smaller than the window of the following error."""
    bench.drives[node].wrong.wraps = 2**bits
    backend = open_backend()
    (axis,) = (item for item in backend.axes.values() if item.spec.node == node)
    if bits == 14:
        assert 2**bits / abs(axis.units.scale) < axis.limits.window
    worst, fault = moved_until_fault(backend, bench, node)
    assert f"the encoder wraps, after {2**bits} counts ({bits} bits)" in str(fault)
    assert worst < 1.1 * (JOINT_STEP if node == JOINT_1 else SPEED * backend.period)


def test_position_range_inside_the_travel_is_refused_at_set_up(bench: Bench, open_backend: Any) -> None:
    """S13: the drive itself says where it starts over (607Bh); nothing has torque."""
    drive = bench.drives[JOINT_1]
    drive.objects[RANGE, 1], drive.objects[RANGE, 2] = -(2**15), 2**15 - 1
    with pytest.raises(EncoderWraps, match=r"joint 1 drive .* wraps every 65536 counts .* inside the travel"):
        open_backend()
    assert {item.life.state for item in bench.drives.values()} == {"SWITCH ON DISABLED"}


@pytest.mark.slow
def test_wheel_that_says_where_it_wraps_rolls_on(bench: Bench, open_backend: Any) -> None:
    drive = bench.drives[LEFT]
    drive.objects[RANGE, 1], drive.objects[RANGE, 2] = 0, 2**18 - 1
    backend = open_backend()
    axis = backend.axes["left wheel"]
    for _ in range(60):
        backend.get(Base).drive(0.5, 0.0)
        backend.step()
    assert drive.position > 2 * 2**18
    assert axis.travel == pytest.approx(drive.position / axis.units.scale, abs=1e-4)


def test_wheel_that_wraps_too_often_to_tell_is_refused(bench: Bench, open_backend: Any) -> None:
    """S13: within a few periods at full speed it could have gone either way."""
    drive = bench.drives[LEFT]
    drive.objects[RANGE, 1], drive.objects[RANGE, 2] = 0, 2**16 - 1
    with pytest.raises(EncoderWraps, match=r"left wheel drive .*0\.126 m of the rim\); needed: more than"):
        open_backend()


def spoilt(find: str, replacement: str) -> str:
    text = maker_eds()
    assert text.count(find) == 1
    return text.replace(find, replacement)


POSITION = "[6064]\nParameterName=Position actual value\nObjectType=0x7\nDataType=0x0004\n"
LOWEST = (
    "ParameterName=Min position range limit\nObjectType=0x7\nDataType=0x0004\nAccessType=rw\nDefaultValue="
)
HIGHEST = LOWEST.replace("Min", "Max")


def counting(lowest: str, highest: str) -> str:
    text = spoilt(LOWEST + "-2147483648", LOWEST + lowest)
    return text.replace(HIGHEST + "2147483647", HIGHEST + highest)


WRAPS = "maker.eds its position (6064h) wraps every 65536 counts (0.0628 m or rad)"


@pytest.mark.parametrize(
    ("eds", "words"),
    [
        (
            counting("0", "65535"),
            WRAPS,
        ),
        (spoilt(POSITION, POSITION + "LowLimit=-32768\nHighLimit=32767\n"), WRAPS),
        (spoilt(POSITION, POSITION.replace("0x0004", "0x0003")), "0003h, which wraps every 65536 counts"),
        (
            spoilt(POSITION, POSITION.replace("0x0004", "0x0007")),
            "0007h; allowed: 0004h, INTEGER32",
        ),
    ],
)
def test_eds_whose_position_wraps_inside_the_travel_is_refused(tmp_path: Path, eds: str, words: str) -> None:
    """S13: `check` reads it at the drive's place in the robot's file."""
    with pytest.raises(FileError) as error:
        load_robot(written(tmp_path, eds, (JOINT_1,)))
    (finding,) = error.value.findings
    assert words in str(finding)
    assert "robot.yaml:" in str(finding)


def dictionary(folder: Path, eds: str) -> ObjectDictionary:
    (folder / "drive.eds").write_text(eds, encoding="utf-8")
    return read_eds(folder / "drive.eds", 1)


def test_range_limits_that_are_both_zero_mean_no_range(tmp_path: Path) -> None:
    none = counting("0", "0")
    assert described_range(dictionary(tmp_path, none)) == PositionRange(-(2**31), 2**31 - 1)
    assert described_range(dictionary(tmp_path, maker_eds(RANGE))) == PositionRange(-(2**31), 2**31 - 1)


@pytest.mark.parametrize(
    ("jump", "uncertainty", "bits"),
    [(65536, 2, 16), (-32700, 2, 15), (10**6, 2, None), (65536, 40000, None), (100, 2, None), (0, 2, None)],
)
def test_encoder_bits_are_named_only_where_a_jump_fits(
    jump: int, uncertainty: float, bits: int | None
) -> None:
    assert encoder_bits(jump, uncertainty) == bits
