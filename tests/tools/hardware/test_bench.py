"""`handcart bench`: drives as a process of their own."""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from handcart.backends.can.can_backend import CanBackend
from handcart.backends.capabilities.base import Base
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.kinematic.kinematic_backend import KinematicBackend
from handcart.backends.loading.robot_loading import load_robot
from handcart.tools.hardware.bench import AT_THE_PROGRAM
from tests.tools.conftest import Said

CHANNEL = "239.74.163.31"


@pytest.fixture
def far() -> RobotFile:
    """The cart, its drives on the bus of the bench."""
    cart = load_robot("cart")
    assert cart.can is not None
    spec = cart.can.model_copy(
        update={
            "interface": "udp_multicast",
            "channel": CHANNEL,
            "heartbeat_ms": 200,
            "heartbeat_timeout_ms": 2000,
        }
    )
    return cart.model_copy(update={"can": spec})


@pytest.fixture
def bench(tmp_path: Path) -> Iterator[Path]:
    """A bench in another process; the path of what it writes."""
    log = tmp_path / "bench.csv"
    words = ["cart", "--channel", CHANNEL, "--log", str(log), "--seconds", "60"]
    command = [sys.executable, "-m", "handcart", "bench", *words]
    with subprocess.Popen(command, stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        assert b"left wheel 1, right wheel 2" in process.stdout.readline()
        yield log
        process.terminate()
        assert process.wait(20.0) == 0


@pytest.mark.slow
def test_wheels_are_driven_over_the_network(
    far: RobotFile, bench: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(
        "handcart.backends.live.pace.MAX_PERIOD_EXCESS_S", 30.0
    )  # machines that tests run on may be busy
    monkeypatch.setattr("handcart.backends.live.pace.MAX_MISSED_PERIODS", 10_000)
    with CanBackend.build(far, None, 0) as backend:
        base = backend.get(Base)  # type: ignore[type-abstract]
        assert base is not None
        begun = time.monotonic()
        for _ in range(20):
            base.drive(0.2, 0.0)
            backend.step()
        left, right, _ = base.wheel_travel()
        assert left == pytest.approx(right, abs=0.2 * 0.01)  # the second one may be read 10 ms later
        assert 0.05 < left < 0.05 + 0.2 * (time.monotonic() - begun)  # the drives have a clock of their own
        assert backend.figures()["loop"]["periods"] == 20
    time.sleep(1.0)
    last = bench.read_text().splitlines()[-1].split(",")
    assert [item.split(":")[2] for item in last[2:]] == ["0.0", "0.0"]


def test_faults_are_listed(handcart: Callable[..., Said]) -> None:
    said = handcart("bench", "--list-faults")
    assert said.status == 0
    assert "no-heartbeat       C7        a drive's heartbeat is missing" in said.out
    assert all(name in said.out for name in AT_THE_PROGRAM)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--fault", "falt@1"), "did you mean 'fault'"),
        (("--fault", "bus-off@1"), "happens at the program's own interface"),
        (("--seconds", "nan"), "Invalid value for '--seconds'"),
        (("--fault", "fault@soon"), "allowed: NAME@SECONDS or NAME@SECONDS@NODE"),
        (("--interface", "udp_multicast", "--channel", "10.0.0.1"), "no CAN on udp_multicast 10.0.0.1"),
        (("--log", "nowhere/log.csv"), "nowhere/log.csv can't be written: No such file or directory"),
        (("--range-port", "7000"), "--range-port without a simulated lidar; needed: --backend kinematic"),
    ],
)
def test_bad_input(handcart: Callable[..., Said], words: tuple[str, ...], message: str) -> None:
    said = handcart("bench", "cart", "--channel", CHANNEL, *words)
    assert said.status == 2
    assert message in said.err


def test_simulated_robot_is_closed_after_an_error(
    handcart: Callable[..., Said], monkeypatch: pytest.MonkeyPatch
) -> None:
    closed = list[KinematicBackend]()
    monkeypatch.setattr(KinematicBackend, "close", lambda self: closed.append(self))
    said = handcart("bench", "cart", "--backend", "kinematic", "--channel", "10.0.0.1")
    assert (said.status, len(closed)) == (2, 1)


def test_a_refused_bench_leaves_a_log_as_it_is(handcart: Callable[..., Said], tmp_path: Path) -> None:
    log = tmp_path / "bench.csv"
    log.write_text("of another bench", encoding="utf-8")
    for words in (("--channel", "10.0.0.1"), ("--channel", CHANNEL, "--range-port", "7000")):
        assert handcart("bench", "cart", *words, "--log", str(log)).status == 2
        assert log.read_text(encoding="utf-8") == "of another bench"


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--ros2", "--log", "log.csv"), "--log with --ros2; allowed: without --ros2, for CAN drives"),
        (("--ros2", "--channel", "can0", "--range-port", "2000"), "--channel, --range-port with --ros2"),
        (("--ros2", "--interface", "virtual"), "--interface with --ros2"),
        (("--ros2", "--task", "drive_map", "--world", "w.yaml"), "--world with --task"),
        (("--wrong", "wheel_radius=1.1"), "--wrong without --ros2; allowed: with --ros2"),
        (("--task", "drive_map"), "--task without --ros2"),
        (("--world", "w.yaml"), "--world without --backend"),
    ],
)
def test_options_of_the_other_kind_of_bench_are_refused(
    handcart: Callable[..., Said], words: tuple[str, ...], message: str
) -> None:
    said = handcart("bench", "cart", *words, "--seconds", "0.1")
    assert (said.status, said.out) == (2, "")
    assert message in " ".join(said.err.split())


@pytest.mark.parametrize(
    ("fault", "words"),
    [
        ("fault@0@99", "'fault@0@99': no drive has the node 99; allowed: 1, 2"),
        ("fault@nan", "'fault@nan' is not a fault"),
        ("fault@soon", "'fault@soon' is not a fault"),
    ],
)
def test_a_planned_fault_that_cannot_happen_is_refused(
    handcart: Callable[..., Said], fault: str, words: str
) -> None:
    said = handcart("bench", "cart", "--interface", "virtual", "--fault", fault, "--seconds", "0.2")
    assert said.status == 2
    assert words in " ".join(said.err.split())
