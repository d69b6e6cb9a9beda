"""The simulated indoor positioning: its rate, its latency, its noise."""

from __future__ import annotations

import numpy as np
import pytest

from handcart.backends.capabilities.positioning import PoseReading
from handcart.backends.description.sensor_specs import PositioningSpec
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.plain_values import attributes, set_attributes
from handcart.backends.simulation.sensors.simulated_positioning import SimulatedPositioning
from handcart.backends.simulation.simulated_backend import build_scene
from handcart.backends.simulation.world.scene import Scene
from handcart.backends.simulation.world_files.world_model import world_model
from handcart.robotics.geometry.pose2 import Pose2

EMPTY = world_model().model_validate({"format": "handcart-world/1", "start": {"x_m": 0.0, "y_m": 0.0}})
PERIOD = 0.01


@pytest.fixture
def scene() -> Scene:
    return build_scene(load_robot("atrv").without_errors(), EMPTY, 0)


def made(scene: Scene, seed: int = 0, **changed: float) -> SimulatedPositioning:
    spec = PositioningSpec(sigma_mm=0.3, heading_sigma_mrad=0.3, rate_hz=20.0, latency_s=0.03)
    return SimulatedPositioning(spec.model_copy(update=changed), scene, PERIOD, seed)


def readings(
    system: SimulatedPositioning, scene: Scene, periods: int, speed: float = 0.0
) -> list[PoseReading]:
    """Each new one, while the base goes ahead along x."""
    found: list[PoseReading] = []
    for number in range(1, periods + 1):
        scene.move_base(Pose2(scene.base.x + speed * PERIOD, 0.0, 0.0))
        system.advance(number)
        reading = system.reading()
        if reading is not None and (not found or reading.number != found[-1].number):
            found.append(reading)
    return found


def test_nothing_is_known_before_the_first_reading_arrives(scene: Scene) -> None:
    system = made(scene)
    assert system.reading() is None
    assert [reading.number for reading in readings(system, scene, 3)] == [1]


def test_readings_come_at_their_rate_and_late(scene: Scene) -> None:
    taken = readings(made(scene, sigma_mm=0.0, heading_sigma_mrad=0.0), scene, 100, speed=1.0)
    assert [item.number for item in taken] == list(range(1, len(taken) + 1))
    assert len(taken) == 20
    for item in taken:
        assert item.age == pytest.approx(0.03)
        assert item.pose.x == pytest.approx((item.number - 1) * 0.05, abs=1e-9)


def test_its_noise_is_what_the_file_says(scene: Scene) -> None:
    poses = np.array([reading.pose for reading in readings(made(scene), scene, 4000)])
    assert poses.mean(axis=0) == pytest.approx(np.array(scene.base), abs=5e-5)
    assert poses.std(axis=0) == pytest.approx([3e-4, 3e-4, 3e-4], rel=0.1)


def test_noise_depends_on_seed_and_reading_alone(scene: Scene) -> None:
    first = readings(made(scene, seed=3), scene, 50)
    system = made(scene, seed=3)
    for number in range(1, 51):
        system.advance(number)  # no reading is taken
    reading = system.reading()
    assert reading is not None
    assert reading[:2] == first[-1][:2]
    assert readings(made(scene, seed=4), scene, 50) != first


def test_a_kept_state_goes_on_where_it_was(scene: Scene) -> None:
    system, other = made(scene), made(scene)
    readings(system, scene, 17)
    set_attributes(other, other.STATE, attributes(system, system.STATE))
    for item in (system, other):
        item.advance(18)
    assert other.reading() == system.reading()
