"""Wrappers of a backend follow from the declarations of its capabilities alone."""

from __future__ import annotations

from abc import abstractmethod
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

import numpy as np
import pytest

from handcart.backends.backend import Backend, CommandError
from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.base import Base
from handcart.backends.capabilities.capability import Capability, Reading
from handcart.backends.capabilities.gps import Fix, Gps
from handcart.backends.capabilities.imu import Imu
from handcart.backends.sensors.all_kinds import all_capabilities
from handcart.evaluation.conformance.faults.fault import FOR_GOOD, Fault, FaultKind, all_sensors
from handcart.evaluation.conformance.faults.faulty_backend import FaultyBackend, InjectedError
from handcart.evaluation.conformance.rig.bench import KitBench
from handcart.evaluation.conformance.rig.parts import needed
from handcart.evaluation.layers import layered_backend

ROOT = Path(__file__).resolve().parents[3]


class Load(NamedTuple):
    number: int
    grams: float
    raw: np.ndarray
    place: str


class Scale(Capability):
    """A scale in the hand, as an outside package might add it."""

    READINGS: ClassVar = {"load": Reading("scale", ("grams", "raw"))}
    COMMANDS = ("tare",)

    @abstractmethod
    def load(self) -> Load: ...

    @abstractmethod
    def tare(self, grams: float) -> None: ...

    @property
    @abstractmethod
    def most(self) -> float: ...


class OwnScale(Scale):
    most = 5.0

    def __init__(self) -> None:
        self.count = 0

    def load(self) -> Load:
        self.count += 1
        return Load(self.count, 3.0, np.ones(2), "hand")

    def tare(self, grams: float) -> None:
        self.count = 0


class WithScale(Backend):
    name, period = "scaled", 0.05

    def __init__(self) -> None:
        self.scale = OwnScale()

    @classmethod
    def build(cls, *_: Any) -> Backend:
        return cls()

    def capabilities(self) -> tuple[Capability, ...]:
        return (self.scale,)

    def step(self) -> None: ...

    def stop(self) -> None: ...

    def close(self) -> None: ...


@pytest.fixture
def faulty(monkeypatch: pytest.MonkeyPatch) -> FaultyBackend:
    """Around a robot with a scale, a capability of a test's own."""
    kinds = (*all_capabilities(), Scale)
    monkeypatch.setattr(layered_backend, "all_capabilities", lambda: kinds)
    return FaultyBackend(WithScale())


def test_a_layer_passes_on_what_a_new_capability_does(faulty: FaultyBackend) -> None:
    scale = needed(faulty, Scale)
    assert not isinstance(scale, OwnScale)
    assert scale.load().grams == 3.0
    assert scale.most == 5.0
    scale.tare(1.0)
    assert scale.load().number == 1


def test_faults_reach_a_new_capability(faulty: FaultyBackend) -> None:
    scale = needed(faulty, Scale)
    scale.load()
    faulty.inject(Fault(FaultKind.NAN, "scale", 1))
    broken = scale.load()
    assert np.isnan(broken.grams)
    assert np.isnan(broken.raw).all()
    assert (broken.number, broken.place) == (2, "hand")
    faulty.inject(Fault(FaultKind.STALE, "scale", 1))
    assert scale.load().number == 2
    faulty.step()
    assert scale.load().number == 3


def test_a_stale_sensor_repeats_its_own_reading(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of two sensors of one kind, each repeats what itself has read last."""
    monkeypatch.setattr(layered_backend, "all_capabilities", lambda: (*all_capabilities(), Scale))
    other, both = OwnScale(), WithScale()
    other.count = 6
    monkeypatch.setattr(both, "capabilities", lambda: (both.scale, other))
    faulty = FaultyBackend(both)
    scales: list[Any] = list(faulty.capabilities())
    assert [scale.load().number for scale in scales] == [1, 7]
    faulty.inject(Fault(FaultKind.STALE, "scale", FOR_GOOD))
    assert [scale.load().number for scale in scales] == [1, 7]


def test_a_second_stuck_fault_holds_what_is_commanded_next() -> None:
    with KitBench("kinematic", "librarian").rig() as rig:
        faulty = FaultyBackend(rig.backend)
        arm, base = needed(faulty, Arm), needed(faulty, Base)
        faulty.inject(Fault(FaultKind.STUCK, periods=FOR_GOOD))
        arm.move(arm.command())
        assert faulty.bitten == 1
        faulty.inject(Fault(FaultKind.STUCK, periods=FOR_GOOD))
        before = base.wheel_travel()
        for _ in range(20):
            base.drive(0.1, 0.0)
            faulty.step()
        assert faulty.bitten == 21
        assert base.wheel_travel() == pytest.approx(before)


@pytest.mark.parametrize(("speed", "turn_rate"), [(0.1, 0.0), (-0.1, 0.0), (0.0, 0.12), (0.0, -0.12)])
def test_slow_standing_base_slides_as_fast_as_it_can(speed: float, turn_rate: float) -> None:
    with KitBench("kinematic", "librarian").rig() as rig:
        faulty, inner = FaultyBackend(rig.backend), needed(rig.backend, Base)
        drive, driven = inner.drive, list[tuple[float, ...]]()

        def slow(ahead: float, turn: float, sideways: float = 0.0) -> None:
            if max(abs(ahead), abs(turn)) > 0.04:
                raise CommandError("too fast; allowed: 0.04")
            driven.append((ahead, turn))
            drive(ahead, turn)

        inner.drive = slow  # type: ignore[assignment, method-assign]
        faulty.inject(Fault(FaultKind.SLIP, periods=10, speed=speed, turn_rate=turn_rate))
        for _ in range(10):
            faulty.step()
        assert faulty.bitten
        assert len(driven) == 10
        assert all(any(command) for command in driven)


@pytest.mark.parametrize(("sensor", "error"), [("scale", InjectedError), ("", InjectedError)])
def test_exceptions_reach_a_new_capability(faulty: FaultyBackend, sensor: str, error: type) -> None:
    scale = needed(faulty, Scale)
    faulty.inject(Fault(FaultKind.EXCEPTION, sensor, FOR_GOOD))
    with pytest.raises(error):
        scale.load() if sensor else scale.tare(1.0)


def test_a_new_capability_s_commands_can_be_refused(faulty: FaultyBackend) -> None:
    faulty.inject(Fault(FaultKind.REFUSED))
    with pytest.raises(CommandError):
        needed(faulty, Scale).tare(1.0)


def test_imu_and_gps_are_in_the_kit_like_the_others() -> None:
    assert {"imu", "gps", "positioning"} < set(all_sensors())
    with KitBench("kinematic", "el_verde").rig() as rig:
        faulty = FaultyBackend(rig.backend)
        for _ in range(40):
            faulty.step()
            needed(faulty, Imu).rates()
            if (fix := needed(faulty, Gps).fix()) is not None:
                break
        assert fix is not None
        faulty.inject(Fault(FaultKind.NAN, "gps", FOR_GOOD))
        broken = needed(faulty, Gps).fix()
        assert isinstance(broken, Fix)
        assert np.isnan([*broken.position, broken.sigma]).all()
        faulty.inject(Fault(FaultKind.STALE, "imu", FOR_GOOD))
        before = needed(faulty, Imu).rates()
        faulty.step()
        assert np.array_equal(needed(faulty, Imu).rates(), before)


def test_what_can_fail_is_declared_and_there() -> None:
    """Each method is a reading, a command, or answered from what was commanded or from the robot's file."""
    never_fail = {"command", "model", "hand_T_camera", "spec"}
    for kind in all_capabilities():
        assert kind.READINGS, kind
        assert {*kind.READINGS, *kind.COMMANDS} == kind.__abstractmethods__ - never_fail, kind


def test_few_files_know_all_kinds() -> None:
    """Besides its own file, only these have to be edited when a kind is added."""
    listing = {
        path.relative_to(ROOT).as_posix()
        for folder in ("backends", "evaluation", "networks", "src", "tools")
        for path in sorted((ROOT / folder).rglob("*.py"))
        if "Gps" in (text := path.read_text(encoding="utf-8")) and "Gripper" in text
    }
    assert listing - {"evaluation/conformance/rig/backend_liars.py"} <= {
        "backends/sensors/all_kinds.py",
        "src/handcart/__init__.py",
        "backends/description/robot_file.py",
        "backends/simulation/simulated_backend.py",
        "backends/can/can_parts.py",
        "backends/ros2/ros_topics.py",
        "backends/ros2/bench/ros_bench.py",
        "backends/description/ros_spec.py",
        "backends/robot/robot.py",  # only for one that the pose is estimated from
    }
