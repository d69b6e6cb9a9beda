"""A calibration that is off by more than it says is found."""

from __future__ import annotations

import pytest

from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.robot.mounted_camera import mount_of, stated_camera
from handcart.backends.simulation.sensors.true_camera import true_camera
from handcart.evaluation.calibration.calibration_claims import camera_faults, suspension_faults
from handcart.primitives.outcomes.calibrated import Calibrated
from handcart.robotics.geometry.transform import inverse

ROBOT = load_robot("toyama/uncalibrated")


def found(sigmas: float = 1.0, **off: float) -> dict[str, Calibrated]:
    """The truth, but for what is off, and so many times as uncertain."""
    assert ROBOT.camera is not None
    mount = mount_of(ROBOT, ROBOT.camera)
    true, stated = true_camera(ROBOT.camera, mount, ROBOT.errors, 3), stated_camera(ROBOT.camera, mount)
    x, y, z = (1e3 * (inverse(stated.hand_T_camera) @ true.hand_T_camera)[:3, 3]).tolist()
    values = {"focal_px": true.model.K[1, 1], "cx_px": true.model.K[0, 2], "k1": true.model.distortion[0]}
    claims = {
        name: Calibrated(float(value) + off.get(name, 0.0), 0.2 * sigmas) for name, value in values.items()
    }
    claims["xyz_mm"] = Calibrated((x + off.get("xyz_mm", 0.0), y, z), (0.1 * sigmas,) * 3)
    return {f"camera.calibrated.{name}": claim for name, claim in claims.items()}


def test_the_truth_is_taken() -> None:
    assert camera_faults(ROBOT, 3, found()) == []


@pytest.mark.parametrize(("name", "off"), [("focal_px", 5.0), ("cx_px", -4.0), ("k1", 2.0), ("xyz_mm", 4.0)])
def test_what_is_off_is_told(name: str, off: float) -> None:
    (wrong,) = camera_faults(ROBOT, 3, found(**{name: off}))
    assert wrong.startswith(f"{name} is {abs(off):.3g} off (at most ")


@pytest.mark.parametrize(("name", "off"), [("focal_px", 5.0), ("cx_px", -6.0), ("k1", 2.0), ("xyz_mm", 4.0)])
def test_a_calibration_far_off_is_told_whatever_its_sigma(name: str, off: float) -> None:
    (wrong,) = camera_faults(ROBOT, 3, found(100.0, **{name: off}))
    assert wrong.startswith(f"{name} is {abs(off):.3g} off (at most ")


def test_a_suspension_is_held_against_the_spots() -> None:
    spots = {"laser_yaw_mrad_per_swing": -0.8, "laser_roll_mrad_per_m": -8.0, "laser_pitch_mrad_per_m": 8.0}
    claims = {"yaw_mrad_per_swing": -0.85, "roll_mrad_per_m": -8.3, "pitch_mrad_per_m": 7.9, "pivot_m": 0.1}
    values = {f"suspension.{name}": Calibrated(value, 0.05) for name, value in claims.items()}
    assert suspension_faults(spots, values) == []
    values["suspension.roll_mrad_per_m"] = Calibrated(-11.0, 0.05)
    (wrong,) = suspension_faults(spots, values)
    assert wrong == "roll_mrad_per_m is 3 off (at most 1.75)"
    values["suspension.roll_mrad_per_m"] = Calibrated(-12.0, 50.0)
    (wrong,) = suspension_faults(spots, values)
    assert wrong == "roll_mrad_per_m is 4 off (at most 3.75)"
