"""A robot as it was put together finds out how its camera sees and how its base gives."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from handcart.evaluation.calibration.laser_survey import read_spot
from handcart.evaluation.trials.running import run_task
from handcart.files.models.loading import load
from handcart.networks.runs.calibration import Calibration
from handcart.networks.runs.run_options import RunOptions
from handcart.primitives.calibration.calibrate_camera import _lens
from handcart.robotics.geometry.transform import transform

TASKS = Path(__file__).resolve().parents[2] / "tasks"
TRUE = {"roll_mrad_per_m": -8.0, "pitch_mrad_per_m": 8.0, "pivot_m": 0.15}


def findings(folder: str) -> Calibration:
    return load(Path(folder) / "calibration.yaml", Calibration)


@pytest.mark.slow
def test_the_camera_of_a_new_robot(tmp_path: Path) -> None:
    """Its mount and focal length are off, as the seed draws them; how its base leans isn't known yet."""
    settings = {"robot": "toyama/uncalibrated", "views": "24"}
    summary, status = run_task(
        TASKS / "calibrate_camera" / "task.yaml", tmp_path, RunOptions(settings=settings, seed=4)
    )
    assert status == 0, summary["reason"]
    figures = summary["metrics"]
    assert figures["untrue"] == []
    assert figures["point_error_before_mm_mean"] > 3.0
    assert figures["point_error_after_mm_max"] < 2.0
    assert figures["mount_error_after_mrad"] < 1.5
    found = findings(summary["run_dir"])
    assert found.robot == "toyama/uncalibrated"
    focal, rpy = (found.found[f"camera.calibrated.{name}"] for name in ("focal_px", "rpy_deg"))
    assert not isinstance(focal.sigma, tuple)
    assert focal.sigma < 0.5
    assert isinstance(rpy.value, tuple)
    assert len(rpy.value) == 3


@pytest.mark.slow
def test_how_the_base_gives(tmp_path: Path) -> None:
    settings = {"robot": "toyama/h1", "rounds": "3", "swings": "8"}
    summary, status = run_task(
        TASKS / "calibrate_suspension" / "task.yaml", tmp_path, RunOptions(settings=settings, seed=2)
    )
    assert status == 0, summary["reason"]
    figures = summary["metrics"]
    assert figures["untrue"] == []
    found = findings(summary["run_dir"]).found
    for name, true in TRUE.items():
        each: Any = found[f"suspension.{name}"]
        assert abs(each.value - true) < 4.0 * each.sigma, name
        assert each.sigma < abs(true) / 4.0, name
    # Both ways saw the same swings, so their spread doesn't part them.
    assert figures["yaw_mrad_per_swing"] == pytest.approx(figures["laser_yaw_mrad_per_swing"], abs=0.15)
    assert figures["yaw_mrad_per_swing"] == pytest.approx(-0.8, abs=0.5)
    for name in ("roll", "pitch"):
        assert figures[f"laser_{name}_mrad_per_m"] == pytest.approx(TRUE[f"{name}_mrad_per_m"], abs=0.3)


@pytest.mark.slow
def test_a_sheet_too_small_is_no_calibration(tmp_path: Path) -> None:
    """Landmarks in a row do not determine the tilt: a Fail, the robot as it was, and no file."""
    settings = {"rounds": "1", "swings": "4", "landmarks": "[near_left, middle, near_right]"}
    task = TASKS / "calibrate_suspension" / "task.yaml"
    summary, status = run_task(task, tmp_path, RunOptions(settings=settings, seed=2))
    assert status == 3
    assert "can't determine roll_per_m" in summary["reason"]
    assert summary["metrics"]["untrue"] == []
    assert not (Path(summary["run_dir"]) / "calibration.yaml").exists()


def test_spots_are_read_with_a_ruler() -> None:
    first = transform((2.0, 1.3, 0.0), (0.0, 0.0, 0.3))
    turned = first @ transform(rpy=(0.0, 0.0, 4e-3))
    assert read_spot(turned, first, 0.0, 0.001) == pytest.approx([0.008, 0.0], abs=1e-12)
    leaned = first @ transform(rpy=(0.0, 1.3e-3, 0.0))
    assert read_spot(leaned, first, 0.0, 0.001)[1] == pytest.approx(-0.003, abs=1e-12)
    exactly = read_spot(leaned, first, 0.0, 0.0)[1]
    assert exactly == pytest.approx(-2.0 * 1.3e-3 + 0.0, rel=1e-3)
    with pytest.raises(ValueError, match="meet the wall"):
        read_spot(first @ transform(rpy=(0.0, 0.0, 3.0)), first, 0.0, 0.001)


def test_coefficients_of_the_lens_are_named_in_opencvs_order() -> None:
    """k1, k2, p1, p2, k3; those that the pictures do not determine are not reported."""
    camera = SimpleNamespace(distortion=np.array([0.1, 0.2, 0.3, 0.4, 0.5]))
    sigmas = np.array([1.0, 1.0, 1.0, 1.0, 0.01, 0.02, 0.03, 0.04, 0.0])
    found: Any = SimpleNamespace(camera=camera, sigmas=sigmas)
    learned = {
        name.rpartition(".")[2]: (item.value, item.sigma)
        for name, item in _lens("camera.calibrated", found).items()
    }
    assert learned == {"k1": (0.1, 0.01), "k2": (0.2, 0.02), "p1": (0.3, 0.03), "p2": (0.4, 0.04)}
