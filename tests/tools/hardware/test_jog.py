"""One axis by hand: hold-to-run."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import numpy as np
import pytest

from handcart.backends.can.can_backend import CanBackend
from handcart.backends.capabilities.arm import Arm
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.kinematic.kinematic_backend import KinematicBackend
from handcart.backends.loading.robot_loading import load_robot
from handcart.evaluation.bringup.jog import HAND_SPEED, Jogger, KeyLease, UnknownAxis
from handcart.evaluation.trials.rig import LIBRARY_FOLDER
from tests.conftest import Clock
from tests.tools.conftest import Said


@pytest.fixture(scope="module")
def librarian() -> RobotFile:
    return load_robot("librarian")


@pytest.fixture
def backend(librarian: RobotFile) -> Iterator[CanBackend]:
    made = CanBackend.build_on_bench(librarian, LIBRARY_FOLDER / "world.yaml", 0, KinematicBackend)
    yield made
    made.close()


def always() -> bool:
    return True


def test_u6_a_key_that_isnt_seen_for_300_ms_is_let_go(clock: Clock) -> None:
    """U6: permanently: a key that comes again later moves nothing."""
    seen = [True]
    lease = KeyLease(lambda: seen[0], clock)
    for _ in range(20):
        clock.now += 0.15
        assert lease()
    seen[0] = False
    clock.now += 0.29
    assert lease()
    clock.now += 0.02
    assert not lease()
    seen[0] = True
    assert not lease()


def test_u6_letting_go_stops_the_axis(backend: CanBackend, librarian: RobotFile) -> None:
    """U6: within a period the axis is commanded to stop; it is at rest after its ramp."""
    jogger, left = Jogger(backend, librarian), [10]

    def held() -> bool:
        left[0] -= 1
        return left[0] > 0

    done = jogger.jog("joint 1", math.radians(60.0), held)
    assert done.ended == "let go"
    stands = jogger.position("joint 1")
    for _ in range(20):
        backend.step()
    assert jogger.position("joint 1") == pytest.approx(stands, abs=2e-4)
    assert done.way < math.radians(30.0)


@pytest.mark.parametrize("axis", ["left wheel", "right wheel", "joint 1", "joint 4", "gripper"])
def test_one_axis_moves_and_no_other(backend: CanBackend, librarian: RobotFile, axis: str) -> None:
    jogger = Jogger(backend, librarian)
    jogger.settle()
    before = {item: jogger.position(item) for item in jogger.axes}
    way = 0.05 if axis != "gripper" else 0.02 * (1 if before[axis] < 0.03 else -1)
    done = jogger.jog(axis, way, always)
    moved = {item: jogger.position(item) - before[item] for item in jogger.axes}
    assert done.ended == "there"
    assert moved.pop(axis) == pytest.approx(way, rel=0.1)
    assert all(abs(item) < 1e-3 for item in moved.values())


@pytest.mark.slow
def test_the_hand_is_never_faster_than_250_mm_s(backend: CanBackend, librarian: RobotFile) -> None:
    jogger, arm, model = Jogger(backend, librarian), backend.get(Arm), librarian.arm_model()  # type: ignore[type-abstract]
    assert arm is not None
    hands = []

    def held() -> bool:
        hands.append(model.forward(arm.joints())[:3, 3])
        return len(hands) < 40

    for axis, way in (("joint 1", 0.3), ("joint 2", 0.2), ("joint 4", 0.3)):
        hands.clear()
        done = jogger.jog(axis, way, held)
        speeds = np.linalg.norm(np.diff(hands, axis=0), axis=1) / backend.period
        assert 0.03 < speeds.max() <= 1.05 * HAND_SPEED, axis
        jogger.jog(axis, -done.way, always)


def test_a_joint_stops_at_its_limit(backend: CanBackend, librarian: RobotFile) -> None:
    jogger = Jogger(backend, librarian)
    lower, upper = jogger.limits("joint 6")
    done = jogger.jog("joint 6", upper + 1.0, always)
    assert done.ended == "limit"
    assert jogger.position("joint 6") == pytest.approx(upper, abs=1e-3)
    assert lower < upper


def test_an_unknown_axis(backend: CanBackend, librarian: RobotFile) -> None:
    with pytest.raises(UnknownAxis, match="unknown axis 'joint 9'"):
        Jogger(backend, librarian).jog("joint 9", 0.1, always)


def test_the_command(handcart: Callable[..., Said]) -> None:
    said = handcart("jog", "librarian", "joint 2", 5, "--bench", "kinematic")
    assert said.status == 0
    assert said.out.startswith("joint 2: moved by 5.")
    refused = handcart("jog", "librarian", "joint 2", 5)
    assert refused.status == 2  # no interface can0, or no terminal
