from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from handcart.backends.backend import CommandError
from handcart.backends.can.bus.errors import NoDrives, TooManyCounts
from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.base import Base
from handcart.backends.capabilities.range_sensor import RangeSensor
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.registry import make_backend
from handcart.backends.saved_state import pack, unpack
from handcart.robotics.numerics.arrays import FloatArray

from .conftest import COUNTS_PER_M, LEFT, RIGHT, Make

RAMPS = 12  # periods within which the wheels come to rest from any speed of these tests


def run(backend: Any, periods: int, speed: float = 0.0, turn_rate: float = 0.0) -> None:
    for _ in range(periods):
        backend.get(Base).drive(speed, turn_rate)
        backend.step()


def targets(backend: Any) -> list[int]:
    """Return the last commanded velocities of the drives, in counts/s."""
    return [drive.rpdo[1][0x60FF].raw for drive in backend.bench.drives.values()]


def test_speeds_are_metres_and_radians_and_left_is_left(make: Make) -> None:
    for speed, turn_rate in ((0.3, 0.0), (-0.3, 0.0), (0.0, 0.8), (0.2, -0.5)):
        backend = make()
        start = backend.ground_truth().base
        run(backend, 20, speed, turn_rate)
        run(backend, RAMPS)
        travel = backend.get(Base).wheel_travel()
        # Speeding up costs what slowing down gives.
        assert travel.left == pytest.approx(speed - 0.25 * turn_rate, abs=1e-4)
        assert travel.right == pytest.approx(speed + 0.25 * turn_rate, abs=1e-4)
        moved = backend.ground_truth().base.relative_to(start)
        assert moved.theta == pytest.approx(turn_rate, rel=0.03, abs=0.03)
        if turn_rate == 0.0:
            assert moved.x == pytest.approx(speed, rel=0.02)
            assert moved.x != pytest.approx(speed, rel=1e-5)  # radii and slip


def test_counts_have_the_sign_of_the_file(make: Make) -> None:
    backend = make(room=False)
    run(backend, 20, 0.3)
    run(backend, RAMPS)
    left, right = (backend.bench.drives[node].position for node in (LEFT, RIGHT))
    assert left == pytest.approx(0.3 * COUNTS_PER_M, rel=1e-4)
    assert right == pytest.approx(-left)
    assert backend.get(Base).wheel_travel()[:2] == pytest.approx((0.3, 0.3), rel=1e-4)


def test_travel_goes_on_where_32_bits_go_over(make: Make) -> None:
    backend = make(room=False)
    for node in (LEFT, RIGHT):
        backend.bench.drives[node].stand_at(2.0**31 - 1000.0)
    backend.step()
    before = backend.get(Base).wheel_travel()
    run(backend, 20, 0.3)
    run(backend, RAMPS)
    after = backend.get(Base).wheel_travel()
    assert np.subtract(after, before)[:2] == pytest.approx([0.3, 0.3], rel=1e-4)


@pytest.mark.parametrize(
    "command",
    [(math.nan, 0.0), (0.0, math.nan), (math.inf, 0.0), (0.0, -math.inf), (0.61, 0.0), (0.0, 1.58)],
)
def test_what_no_robot_may_do_is_refused(make: Make, command: tuple[float, float]) -> None:
    backend = make()
    with pytest.raises(CommandError, match="allowed"):
        backend.get(Base).drive(*command)
    backend.step()
    assert backend.get(Base).wheel_travel()[:2] == (0.0, 0.0)


def test_a_command_that_is_not_renewed_lives_one_period(make: Make) -> None:
    backend = make()
    backend.get(Base).drive(0.6, 0.0)
    backend.step()
    backend.step()
    assert targets(backend) == [0, 0]
    run(backend, RAMPS)
    there = backend.ground_truth().base
    backend.step()
    assert backend.ground_truth().base == there


def test_a_command_does_nothing_before_its_step(make: Make) -> None:
    backend = make()
    there = backend.ground_truth().base
    backend.get(Base).drive(0.3, 0.0)
    assert backend.get(Base).wheel_travel()[:2] == (0.0, 0.0)
    assert backend.ground_truth().base == there


def test_after_stop_nothing_is_queued(make: Make) -> None:
    backend = make()
    backend.get(Base).drive(0.3, 0.0)
    backend.stop()
    before = backend.ground_truth().base
    for _ in range(5):
        backend.step()
    assert backend.ground_truth().base == before
    run(backend, 20, 0.3)
    assert targets(backend) == pytest.approx([0.3 * COUNTS_PER_M, -0.3 * COUNTS_PER_M], abs=1)
    backend.stop()
    backend.bench.serve()
    assert targets(backend) == [0, 0]  # at once, not with the next step
    for _ in range(RAMPS):
        backend.step()
    there = backend.ground_truth().base
    backend.step()
    assert backend.ground_truth().base == there
    run(backend, 5, 0.3)  # and it can be driven again
    assert backend.ground_truth().base != there


def test_the_same_seed_gives_the_same_readings(make: Make) -> None:
    def readings(seed: int) -> tuple[tuple[float, ...], FloatArray]:
        backend = make(seed)
        run(backend, 15, 0.2, 0.4)
        rolled = (*backend.get(Base).wheel_travel(), *backend.ground_truth().base)
        return rolled, backend.get(RangeSensor).scan().ranges

    one, same, other = readings(5), readings(5), readings(6)
    assert one[0] == same[0] and np.array_equal(one[1], same[1])
    assert one[0] != other[0] and not np.array_equal(one[1], other[1])


def test_a_wall_stops_the_base_and_is_noted(make: Make) -> None:
    backend = make()
    run(backend, 100, 0.4)
    assert backend.ground_truth().base.y == pytest.approx(3.0 - 0.34, abs=0.06)
    assert [(contact.body, contact.time > 0.0) for contact in backend.inner.scene.contacts] == [
        ("base", True)
    ]


def test_without_a_world_there_are_wheels_alone(make: Make) -> None:
    backend = make(room=False)
    assert backend.ground_truth() is None
    assert backend.get(RangeSensor) is None
    run(backend, 2, 0.1)
    assert backend.get(Base).wheel_travel().left > 0.0


def test_closing_takes_the_torque_away_at_rest(make: Make) -> None:
    backend = make()
    run(backend, 20, 0.5)
    backend.close()
    backend.close()
    for drive in backend.bench.drives.values():
        assert (drive.velocity, drive.life.state) == (0.0, "SWITCH ON DISABLED")


def test_a_robot_needs_a_section_can() -> None:
    with pytest.raises(NoDrives, match="no section 'can'"):
        make_backend("can", load_robot("toyama"), None, 0)


def test_counts_that_do_not_fit_are_told(make: Make, cart: RobotFile) -> None:
    assert cart.can is not None
    fine = cart.can.left.model_copy(update={"counts_per_rev": 2**24, "gear_ratio": 100.0})
    robot = cart.model_copy(update={"can": cart.can.model_copy(update={"left": fine})})
    with pytest.raises(TooManyCounts, match=r"the left wheel drive .* would be told .* counts_per_rev"):
        make(robot=robot)


@pytest.mark.slow
def test_a_world_that_is_put_back_goes_on_as_it_would_have(make: Make) -> None:
    robot = load_robot("librarian")

    def on(backend: Any, periods: int) -> tuple[tuple[float, ...], FloatArray, FloatArray]:
        arm = backend.get(Arm)
        for _ in range(periods):
            backend.get(Base).drive(0.2, 0.1)
            arm.move(arm.command() + 0.01)
            backend.step()
        for _ in range(RAMPS):
            backend.step()
        rolled = (*backend.get(Base).wheel_travel(), *backend.ground_truth().base)
        return rolled, backend.get(Arm).joints(), backend.get(RangeSensor).scan().ranges

    backend = make(3, robot=robot)
    on(backend, 8)
    state = unpack(pack(backend.state()))
    resumed = make(3, robot=robot)
    resumed.set_state(state)
    there, again = on(backend, 8), on(resumed, 8)
    assert again[0] == pytest.approx(there[0], abs=1e-6)
    assert again[1] == pytest.approx(there[1], abs=2e-5)
    assert again[2] == pytest.approx(there[2], abs=1e-3)
    assert resumed.bench.time == pytest.approx(backend.bench.time)


def test_the_force_on_the_hand_follows_from_the_joints_torques(make: Make) -> None:
    robot = load_robot("librarian").without_errors()
    backend = make(robot=robot)
    arm, inner = backend.get(Arm), backend.bench.inner
    backend.step()
    for force in ([0.0, 0.0, 0.0], [-20.0, 3.0, 8.0]):
        backend.inner.scene.hand_force = np.array(force)
        inner._arm._settled = True  # a gripper in contact does not move
        backend.step()
        backend.inner.scene.hand_force = np.array(force)
        assert arm.hand_force() == pytest.approx(force, abs=0.5)
