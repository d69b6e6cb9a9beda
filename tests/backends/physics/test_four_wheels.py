"""A base of four wheels that is steered by its sides, and the positioning that sees it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.base import Base
from handcart.backends.capabilities.positioning import Positioning
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.physics.physics_backend import PhysicsBackend
from handcart.backends.simulation.world_files.world_model import world_model
from handcart.backends.urdf.driven_wheels import NoWheels, driven_wheels

EMPTY = world_model().model_validate({"format": "handcart-world/1", "start": {"x_m": 0.0, "y_m": 0.0}})


@pytest.fixture
def backend(physics: type[PhysicsBackend]) -> Iterator[PhysicsBackend]:
    made = physics(load_robot("atrv").without_errors(), EMPTY, 0)
    yield made
    made.close()


def drive(backend: Any, speed: float, turn_rate: float, seconds: float = 2.0) -> None:
    for _ in range(round(seconds / backend.period)):
        backend.get(Base).drive(speed, turn_rate)
        backend.step()


def test_wheels_are_known_by_their_names() -> None:
    assert driven_wheels(["left_wheel", "right_wheel", "front_left_wheel"]) == (
        ("left_wheel",),
        ("right_wheel",),
    )
    names = ["right_rear_wheel", "left_rear_wheel", "right_front_wheel", "left_front_wheel", "left_finger"]
    assert driven_wheels(names).left == ("left_front_wheel", "left_rear_wheel")
    with pytest.raises(NoWheels, match="drives its right side; needed: a joint 'right_wheel'"):
        driven_wheels(["left_wheel"]).check()


@pytest.mark.slow
@pytest.mark.parametrize("turn_rate", [0.5, -0.5])
def test_it_turns_on_the_spot_as_its_file_has_it(backend: Any, turn_rate: float) -> None:
    drive(backend, 0.0, turn_rate)
    x, y, theta = backend.scene.base
    assert np.hypot(x, y) < 0.03
    assert theta == pytest.approx(2.0 * turn_rate, rel=0.1)
    travel = backend.get(Base).wheel_travel()
    assert travel.right - travel.left == pytest.approx(theta * 0.6, rel=0.1)


@pytest.mark.slow
def test_it_drives_straight(backend: PhysicsBackend) -> None:
    drive(backend, 0.2, 0.0)
    assert backend.scene.base.x == pytest.approx(0.4, abs=0.01)
    assert abs(backend.scene.base.y) < 0.003


@pytest.mark.slow
def test_it_stands_while_the_arm_moves(backend: Any) -> None:
    drive(backend, 0.1, 0.3)
    drive(backend, 0.0, 0.0, 0.5)
    before, arm = backend.scene.base, backend.get(Arm)
    start = arm.command()
    for share in np.linspace(0.0, 1.0, 120):
        arm.move(start + share * (np.radians([60.0, 60.0, -90.0, 30.0, 0.0]) - start))
        backend.step()
    assert backend.scene.base.distance(before) < 2e-4
    assert backend.scene.base.turn(before) < 4e-4  # tyres give a little


def test_the_positioning_tells_where_it_stood(backend: Any) -> None:
    drive(backend, 0.2, 0.0, 0.5)
    then = backend.scene.base
    drive(backend, 0.2, 0.0, backend.period)
    reading = backend.get(Positioning).reading()
    assert reading is not None
    assert reading.age == pytest.approx(backend.period)
    assert reading.pose.distance(then) < 0.001


def test_the_same_again_from_a_kept_state(backend: Any) -> None:
    drive(backend, 0.1, 0.2)
    kept = backend.state()
    drive(backend, 0.1, -0.2, 0.5)
    reading = backend.get(Positioning).reading()
    backend.set_state(kept)
    drive(backend, 0.1, -0.2, 0.5)
    again = backend.get(Positioning).reading()
    assert reading is not None and again is not None
    assert again.number == reading.number
    assert again.pose == pytest.approx(reading.pose, abs=1e-4)
