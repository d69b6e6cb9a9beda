"""Simulated lidars deliver the faults of their drivers."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType

import numpy as np
import pytest

from handcart.backends.capabilities.range_sensor import RangeSensor
from handcart.backends.description.range_spec import RangeSpec
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.registry import make_backend
from handcart.backends.simulation.sensors.range_faults import OWN_BODY_M
from handcart.robotics.numerics.arrays import FloatArray

WORLD = """\
format: handcart-world/1
start: {x_m: 1.0, y_m: 1.0}
walls:
  - {from_m: [0, 0], to_m: [8, 0]}
  - {from_m: [1.6, 0], to_m: [1.6, 6]}
"""
PERIODS = 40
SHARES = {
    "range_zero_percent": 2.0,
    "range_nan_percent": 4.0,
    "range_too_close_percent": 8.0,
    "range_own_body_percent": 16.0,
}


def scans(
    folder: Path, errors: Mapping[str, float] = MappingProxyType({}), seed: int = 0, looks: int = 1
) -> FloatArray:
    """(PERIODS, beams) of a half turn's lidar; asked so often in each period."""
    world = folder / "world.yaml"
    world.write_text(WORLD, encoding="utf-8")
    robot = load_robot("cart")
    spec = RangeSpec(beams=181, reach_m=12.0, range_min_m=0.7, sigma_mm=5.0, start_deg=-90.0, end_deg=90.0)
    erring = robot.errors.model_copy(update=dict(errors))
    robot = robot.model_copy(update={"range_sensor": spec, "errors": erring})
    with make_backend("kinematic", robot, world, seed) as backend:
        sensor = backend.get(RangeSensor)  # type: ignore[type-abstract]
        assert sensor is not None
        taken = []
        for _ in range(PERIODS):
            backend.step()
            for _ in range(looks):
                scan = sensor.scan()
            taken.append(scan.ranges.copy())
    np.testing.assert_allclose(np.degrees(scan.angles), np.linspace(-90.0, 90.0, 181))
    return np.array(taken)


def test_shares_of_beams_read_what_the_file_says(tmp_path: Path) -> None:
    found = scans(tmp_path, SHARES)[:, 130:]  # away from the wall that is too close
    own, close = float((found == OWN_BODY_M).mean()), float((found == -np.inf).mean())
    nan, zero = float(np.isnan(found).mean()), float((found == 0.0).mean())
    assert own == pytest.approx(0.16, abs=0.025)
    assert close == pytest.approx(0.08 * 0.84, abs=0.02)
    assert nan == pytest.approx(0.04 * 0.92 * 0.84, abs=0.015)
    assert zero == pytest.approx(0.02 * 0.96 * 0.92 * 0.84, abs=0.01)


def test_a_wall_below_the_least_range_is_too_close(tmp_path: Path) -> None:
    ahead = scans(tmp_path)[:, 90]  # 0.6 m before it
    assert (ahead == -np.inf).all()


def test_faults_are_of_seed_and_period_alone(tmp_path: Path) -> None:
    once, often = scans(tmp_path, SHARES), scans(tmp_path, SHARES, looks=3)
    np.testing.assert_array_equal(once, often)
    assert not np.array_equal(once, scans(tmp_path, SHARES, seed=1), equal_nan=True)
    assert not np.array_equal(once[0], once[1], equal_nan=True)
    sound, erring = scans(tmp_path), scans(tmp_path, {"range_zero_percent": 10.0})
    np.testing.assert_array_equal(erring[erring != 0.0], sound[erring != 0.0])  # noise stays what it was
