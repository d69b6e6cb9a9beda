import math

import numpy as np
import pytest

from benchmarks.field.field_course import straight_course
from benchmarks.field.field_log import FieldLog, record_course
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.outdoors.field_noise import REFERENCE_NOISE
from handcart.robotics.navigation.outdoors.gyro_odometry import GyroOdometry

DT = 0.025
LEVEL = np.array([0.0, 0.0, 9.81])
STILL = np.zeros(2)
QUIET = REFERENCE_NOISE._replace(
    scale=0.0, slip=0.0, turn_slip=0.0, side_slip=0.0, side_slip_turning=0.0, gyro_white=0.0, gyro_walk=0.0,
    gyro_bias=0.0, gyro_warm_up=0.0, gyro_scale=0.0, accelerometer_white=0.0, accelerometer_bias=0.0,
)  # fmt: skip


def reckon(log: FieldLog, euler: bool) -> tuple[Pose2, Pose2]:
    """Return the true and the dead reckoned pose after the last stop."""
    odometry = GyroOdometry(euler=euler)
    for rates, accelerations, wheels in zip(log.rates, log.accelerations, log.wheels, strict=True):
        odometry.update(rates, accelerations, wheels, DT)
    return Pose2(*log.drive.poses[-1].tolist()), odometry.pose


def test_without_errors_rough_ground_costs_nothing() -> None:
    true, reckoned = reckon(record_course(straight_course(4), QUIET, 1), euler=True)
    assert true.distance(reckoned) < 2e-3
    assert true.turn(reckoned) < 1e-4


@pytest.mark.slow
def test_body_rates_taken_for_rates_of_angles_lose_the_heading() -> None:
    """What the paper's equations do on ground with 2.5 degrees of roughness, and what they should."""
    off: dict[bool, list[float]] = {euler: [] for euler in (True, False)}
    for seed in range(4):
        log = record_course(straight_course(17), QUIET, seed)
        for euler, found in off.items():
            true, reckoned = reckon(log, euler)
            found.append(true.y - reckoned.y)
    assert np.std(off[True]) < 0.01
    assert np.std(off[False]) > 0.2


def test_bias_is_learned_in_a_stop_and_does_not_turn_the_heading() -> None:
    odometry = GyroOdometry(Pose2(1.0, 2.0, 0.5))
    bias = np.array([0.004, -0.003, 0.005])
    for _ in range(400):
        odometry.update(bias, LEVEL, STILL, DT)
    assert odometry.at_rest
    assert odometry.bias == pytest.approx(bias, rel=1e-3)
    turned = odometry.pose.theta
    for _ in range(400):
        odometry.update(bias, LEVEL, np.full(2, 0.0125), DT)
    assert not odometry.at_rest
    assert odometry.pose.theta == pytest.approx(turned, abs=1e-4)
    assert math.dist(odometry.pose[:2], (1.0, 2.0)) == pytest.approx(5.0, abs=0.01)


def test_rest_needs_quiet_accelerometers_too() -> None:
    odometry = GyroOdometry()
    rng = np.random.default_rng(0)
    for _ in range(200):
        odometry.update(np.zeros(3), LEVEL + rng.normal(0.0, 0.5, 3), STILL, DT)
    assert not odometry.at_rest


def test_gravity_levels_and_a_slope_is_climbed() -> None:
    pitch = -0.1  # nose up
    odometry = GyroOdometry()
    felt = 9.81 * np.array([-math.sin(pitch), 0.0, math.cos(pitch)])
    for _ in range(100):
        odometry.update(np.zeros(3), felt, STILL, DT)
    assert odometry.tilt == pytest.approx((0.0, pitch), abs=1e-9)
    for _ in range(100):
        odometry.update(np.zeros(3), felt, np.full(2, 0.01), DT)
    assert odometry.pose.x == pytest.approx(math.cos(pitch))
    assert odometry.height == pytest.approx(math.sin(0.1))


def test_what_is_not_finite_counts_as_the_reading_before() -> None:
    odometry, whole = GyroOdometry(), GyroOdometry()
    rates, wheels = np.array([0.0, 0.0, 0.2]), np.full(2, 0.01)
    for k in range(100):
        broken = k % 10 == 5
        odometry.update(
            np.full(3, np.nan) if broken else rates, np.full(3, np.inf) if broken else LEVEL, wheels, DT
        )
        whole.update(rates, LEVEL, wheels, DT)
    assert odometry.pose == pytest.approx(whole.pose)


def test_advance_is_handed_over_once() -> None:
    odometry = GyroOdometry()
    for _ in range(8):
        odometry.update(np.array([0.0, 0.0, 0.4]), LEVEL, np.full(2, 0.01), DT)
    advance = odometry.take()
    assert advance.forward == pytest.approx(0.08)
    assert advance.turn == pytest.approx(0.08)
    assert advance.time == pytest.approx(0.2)
    assert odometry.take() == (0.0,) * 6
