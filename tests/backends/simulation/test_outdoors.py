"""Open ground and the sensors of a robot on it, simulated."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from handcart.backends.backend import CommandError
from handcart.backends.capabilities.gps import Gps
from handcart.backends.capabilities.imu import Imu
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.kinematic.kinematic_backend import KinematicBackend
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.simulation.field.sensor import Sensor
from handcart.backends.simulation.world.placed_thing import PlacedSpec
from handcart.backends.simulation.world.support import rest_of
from handcart.backends.simulation.world.thing import Rest
from handcart.backends.simulation.world_files.world_model import world_model
from handcart.primitives.field.scara_arm import scara_of
from handcart.robotics.geometry.transform import transform
from handcart.robotics.manipulation.arms.scara import Scara

GROUND = {"format": "handcart-world/1", "start": {"x_m": 0.0, "y_m": 0.0}, "ground": {}}


@pytest.fixture(scope="module")
def robot() -> RobotFile:
    return load_robot("el_verde")


def backend(robot: RobotFile, seed: int = 0, **world: Any) -> Any:
    return KinematicBackend(robot, world_model().model_validate({**GROUND, **world}), seed)


def drive(made: Any, seconds: float, speed: float, turn: float = 0.0) -> None:
    for _ in range(round(seconds / made.period)):
        made._base.drive(speed, turn)
        made.step()


def test_a_car_turns_no_tighter_than_it_steers(robot: RobotFile) -> None:
    made = backend(robot)
    made._base.drive(0.4, 0.2)
    for speed, turn in ((0.0, 0.1), (0.4, 0.21), (0.4, math.nan)):
        with pytest.raises(CommandError, match="allowed"):
            made._base.drive(speed, turn)


@pytest.mark.slow
def test_the_ground_is_as_rough_and_slippery_as_the_file_says(robot: RobotFile) -> None:
    tilts, scales = [], []
    for seed in range(12):
        made = backend(robot, seed)
        drive(made, 60.0, 0.5)
        x, y = made.scene.base.x, made.scene.base.y
        scales.append(made._base.wheel_travel().left / math.hypot(x, y) - 1.0)
        for _ in range(40):
            drive(made, 1.0, 0.5)
            tilts.append(made.scene.lean)
    assert np.std(tilts) == pytest.approx(math.radians(2.5), rel=0.15)
    assert 0.001 < np.std(scales) < 0.006


def test_fixes_come_once_a_second_and_not_in_an_outage(robot: RobotFile) -> None:
    made = backend(robot, sky={"outages": [{"from_s": 20.0, "to_s": 40.0}]})
    times, off = [], []
    for _ in range(round(60.0 / made.period)):
        made.step()
        fix = made.get(Gps).fix()
        if fix is not None:
            times.append(made.scene.time)
            off.append(fix.position)
    assert len(times) == 40
    assert not any(20.0 <= time < 40.0 for time in times)
    assert np.std(off) == pytest.approx(1.0, rel=0.25)


def test_a_standing_imu_reads_its_bias_and_gravity(robot: RobotFile) -> None:
    made = backend(robot, seed=2)
    rates, forces = [], []
    for _ in range(2000):
        made.step()
        rates.append(made.get(Imu).rates())
        forces.append(made.get(Imu).accelerations())
    white = math.radians(0.02) / math.sqrt(made.period)
    assert np.std(np.diff(rates, axis=0), axis=0) == pytest.approx(math.sqrt(2.0) * white, rel=0.1)
    assert np.linalg.norm(np.mean(forces, axis=0)) == pytest.approx(9.81, abs=0.1)


def test_a_world_put_back_goes_on_as_it_was(robot: RobotFile) -> None:
    made = backend(robot, seed=4, sensors={"count": 2})
    drive(made, 5.0, 0.4, 0.1)
    state = made.state()
    again = backend(robot, seed=4, sensors={"count": 2})
    again.set_state(state)
    for item in (made, again):
        drive(item, 5.0, 0.4, -0.1)
    assert made.scene.base == again.scene.base
    assert np.array_equal(made.get(Imu).rates(), again.get(Imu).rates())


def test_the_arm_of_the_file_is_that_of_the_paper(robot: RobotFile) -> None:
    class _Robot:
        spec = robot
        arm_model = robot.arm_model()

    stand_in: Any = _Robot()
    arm = scara_of(stand_in)
    assert arm.upper == pytest.approx(0.395)
    assert arm.fore == pytest.approx(0.610)
    assert arm.theta1_working == pytest.approx(Scara().theta1_working)
    rng = np.random.default_rng(0)
    for joints in rng.uniform(_Robot.arm_model.lower, _Robot.arm_model.upper, (20, 3)):
        assert arm.base_tip(joints) == pytest.approx(_Robot.arm_model.forward(joints)[:3, 3], abs=1e-9)


@pytest.mark.parametrize(
    ("height", "tilt", "rest"),
    [
        (-0.020, 0.0, Rest.TABLE),
        (-0.023, 0.05, Rest.TABLE),
        (-0.030, 0.0, Rest.FLOOR),
        (-0.020, 0.3, Rest.FLOOR),
    ],
)
def test_what_stands_in_a_dip_stands_on_the_ground(
    robot: RobotFile, height: float, tilt: float, rest: Rest
) -> None:
    made = backend(robot)
    made.scene.ground_height = lambda x, y: -0.02 if x > 2.0 else 0.02
    pose = transform((3.0, 1.0, height), (tilt, 0.0, 0.0))
    spec = PlacedSpec(name="1", x_m=0.0, y_m=0.0, height_m=0.0, size_mm=(60.0, 60.0, 90.0))
    assert rest_of(made.scene, Sensor(pose, Rest.HAND, spec)) is rest


@pytest.mark.parametrize(
    ("leans_deg", "rest"), [(14.0, Rest.TABLE), (5.0, Rest.TABLE), (0.0, Rest.FLOOR), (26.0, Rest.FLOOR)]
)
def test_what_stands_on_a_slope_stands_as_the_slope_does(
    robot: RobotFile, leans_deg: float, rest: Rest
) -> None:
    made = backend(robot)
    made.scene.ground_height = lambda x, y: -x * math.tan(math.radians(14.0))
    pose = transform((3.0, 1.0, made.scene.ground_height(3.0, 1.0)), (0.0, math.radians(leans_deg), 0.0))
    spec = PlacedSpec(name="1", x_m=0.0, y_m=0.0, height_m=0.0, size_mm=(60.0, 60.0, 90.0))
    assert rest_of(made.scene, Sensor(pose, Rest.HAND, spec)) is rest
