"""A robot's file in SI units, as its filters outdoors take it."""

from __future__ import annotations

import math

import numpy as np
import pytest

from handcart.backends.description.beacons_spec import BeaconsSpec
from handcart.backends.description.ground_spec import GpsSpec, GroundSpec
from handcart.backends.description.sensor_specs import ImuSpec
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.robot.localization.noise_model import beacon_errors, field_localizer, field_noise
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.beacons.beacon_filter import BeaconFilter
from handcart.robotics.navigation.outdoors.field_noise import REFERENCE_NOISE
from handcart.robotics.navigation.outdoors.gps_filter import GpsFilter
from handcart.robotics.navigation.outdoors.gyro_only import GyroOnly
from handcart.robotics.navigation.outdoors.particle_filter import ParticleFilter

DEGREE = math.pi / 180.0
ANTENNA = (0.4, 0.1, 1.3)
GROUND = GroundSpec(
    roughness_deg=3.0,
    roughness_length_m=0.7,
    scale_percent=1.1,
    slip_percent=1.2,
    slip_length_m=2.3,
    turn_slip_percent=14.0,
    side_slip_deg=1.5,
    side_slip_length_m=3.6,
    side_slip_deg_m=1.7,
)
GPS = GpsSpec(period_s=0.5, white_m=0.8, drift_m=0.9, drift_time_s=310.0, start_heading_deg=2.0)
IMU = ImuSpec(
    angle_random_walk_deg_rt_s=0.03,
    gyro_bias_deg_s=0.4,
    rate_random_walk_deg_s_rt_s=0.002,
    warm_up_deg_s=0.2,
    warm_up_s=610.0,
    gyro_scale_percent=0.6,
    accelerometer_sigma_m_s2=0.07,
    accelerometer_bias_m_s2=0.03,
    vibration_m_s2=0.5,
)
BEACONS = BeaconsSpec(
    places_m={"a": (1.0, 2.0, 3.0), "b": (4.0, 5.0, 6.0), "c": (7.0, -8.0, 9.0)},
    tag_m=(0.1, 0.2, 1.1),
    sigma_m=0.12,
    bias_m=0.32,
    scale_percent=1.5,
    bias_walk_m_rt_s=0.02,
)
ROBOT = load_robot("el_verde").model_copy(
    update={"ground": GROUND, "gps": GPS, "imu": IMU, "beacons": BEACONS, "localizer": "gps_filter"}
)
START = Pose2(1.0, 2.0, 0.5)


def test_each_figure_of_a_file_becomes_si() -> None:
    noise = field_noise(ROBOT, ANTENNA)
    assert noise.antenna == ANTENNA
    assert noise._replace(antenna=0.0) == pytest.approx(  # type: ignore[arg-type]
        REFERENCE_NOISE._replace(
            roughness=3.0 * DEGREE,
            roughness_length=0.7,
            scale=0.011,
            slip=0.012,
            slip_length=2.3,
            turn_slip=0.14,
            side_slip=1.5 * DEGREE,
            side_slip_length=3.6,
            side_slip_turning=1.7 * DEGREE,
            antenna=0.0,  # type: ignore[arg-type]
            gps_period=0.5,
            gps_white=0.8,
            gps_drift=0.9,
            gps_drift_time=310.0,
            start_heading=2.0 * DEGREE,
            gyro_white=0.03 * DEGREE,
            gyro_walk=0.002 * DEGREE,
            gyro_bias=0.4 * DEGREE,
            gyro_warm_up=0.2 * DEGREE,
            gyro_warm_up_time=610.0,
            gyro_scale=0.006,
            accelerometer_white=0.07,
            accelerometer_bias=0.03,
            vibration=0.5,
        )
    )


def test_no_sensor_is_believed_to_be_perfect() -> None:
    perfect = ROBOT.model_copy(
        update={
            "gps": GPS.model_copy(update={"white_m": 0.0}),
            "imu": IMU.model_copy(update={"angle_random_walk_deg_rt_s": 0.0}),
        }
    )
    noise = field_noise(perfect, ANTENNA)
    assert noise.gps_white == 0.003
    assert noise.gyro_white == pytest.approx(1e-4 * DEGREE)
    errors = beacon_errors(BEACONS.model_copy(update={"sigma_m": 0.0, "bias_m": 0.0}))
    assert (errors.white, errors.bias) == (0.005, 0.005)


def test_without_receiver_and_gyros_the_reference_counts() -> None:
    noise = field_noise(ROBOT.model_copy(update={"gps": None, "imu": None}), ANTENNA)
    assert noise.gps_white == REFERENCE_NOISE.gps_white
    assert noise.gyro_white == REFERENCE_NOISE.gyro_white
    assert noise.start_heading == REFERENCE_NOISE.start_heading


def test_beacons_are_where_and_as_wrong_as_the_file_says() -> None:
    errors = beacon_errors(BEACONS)
    assert errors.places.tolist() == [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [7.0, -8.0, 9.0]]
    assert errors.tag == (0.1, 0.2, 1.1)
    assert tuple(errors[2:]) == pytest.approx((0.12, 0.32, 0.015, 0.02))


@pytest.mark.parametrize(
    ("name", "kind"),
    [("gps_filter", GpsFilter), ("beacons", BeaconFilter), ("particle", ParticleFilter), ("gyro", GyroOnly)],
)
def test_the_filter_that_a_file_names_starts_as_told(name: str, kind: type) -> None:
    found = field_localizer(ROBOT.model_copy(update={"localizer": name}), START, ANTENNA)
    assert type(found) is kind
    assert found.pose == pytest.approx(START, abs=0.01)
    spread = 0.1 if name == "particle" else 1e-6
    assert np.sqrt(np.diag(found.covariance))[:2] == pytest.approx([0.05, 0.05], rel=spread)


def test_a_heading_that_nobody_tells_is_not_started_with() -> None:
    robot = ROBOT.model_copy(update={"gps": GPS.model_copy(update={"start_heading_deg": "unknown"})})
    assert math.isinf(field_noise(robot, ANTENNA).start_heading)
    found = field_localizer(robot, START, ANTENNA)
    assert found.pose == (1.0, 2.0, 0.0)
    assert not found.heading_known


def test_tracks_of_the_gps_filter_are_recorded_for_smoothing() -> None:
    found = field_localizer(ROBOT, START, ANTENNA)
    found.mark()
    assert len(found.smoothed()) == 1


@pytest.mark.parametrize(("white", "sigma"), [(0.8, 0.8), (0.01, 0.05)])
def test_particles_take_no_fix_for_better_than_5_cm(white: float, sigma: float) -> None:
    robot = ROBOT.model_copy(
        update={"gps": GPS.model_copy(update={"white_m": white}), "localizer": "particle"}
    )
    found = field_localizer(robot, START, (0.0, 0.0, 0.0))
    found.fix(np.array([1.0, 2.0]))
    after = 1.0 / math.sqrt(1.0 / 0.05**2 + 1.0 / sigma**2)
    assert math.sqrt(found.covariance[0, 0]) == pytest.approx(after, rel=0.1)


def test_unknown_start_heading_is_no_error_of_the_receiver() -> None:
    """A robot that has to find its heading (ORIENT) has to find it with ideal sensors, too."""
    unknown = GPS.model_copy(update={"start_heading_deg": "unknown"}).without_errors()
    assert unknown.start_heading_deg == "unknown"
    assert (unknown.white_m, unknown.drift_m) == (0.0, 0.0)
    assert GPS.without_errors().start_heading_deg != "unknown"
