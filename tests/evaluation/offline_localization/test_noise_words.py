"""Noise that was fitted to a log, as the robot's file takes it."""

from __future__ import annotations

import math

import pytest
import yaml

from handcart.backends.description.ground_spec import GpsSpec, GroundSpec
from handcart.backends.description.sensor_specs import ImuSpec
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.robot.localization.noise_model import field_noise
from handcart.evaluation.offline_localization.noise_fit import in_yaml
from handcart.robotics.navigation.outdoors.field_noise import REALISTIC_NOISE, FieldNoise


@pytest.mark.parametrize("noise", [REALISTIC_NOISE, FieldNoise(gps_drift=2.0, gps_drift_time=100.0)])
def test_printed_noise_is_the_fitted_one_in_a_robots_file(noise: FieldNoise) -> None:
    written = yaml.safe_load(in_yaml(noise))
    given = {"gps": GpsSpec(**written["gps"]), "ground": GroundSpec(**written["ground"])}
    imu = ImuSpec(accelerometer_sigma_m_s2=0.05, **written["imu"])
    read = field_noise(load_robot("el_verde").model_copy(update={**given, "imu": imu}), noise.antenna)
    fitted = ["scale", "slip", "slip_length", "turn_slip", "side_slip", "gyro_white", "gyro_walk"]
    for name in (*fitted, "gyro_bias", "gyro_scale", "gps_white", "gps_drift", "gps_drift_time"):
        assert math.isclose(getattr(read, name), getattr(noise, name), rel_tol=0.01), name
