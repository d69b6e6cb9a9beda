"""Errors of a simulated robot as its file declares them, or declares none."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from handcart.backends.description.robot_file import RobotFile
from handcart.backends.description.robot_names import SHIPPED_FOLDER
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.registry import make_backend

WORLD = SHIPPED_FOLDER.parents[1] / "tasks" / "return_book" / "world.yaml"


def librarian(folder: Path, errors: str) -> RobotFile:
    """Its file with these errors."""
    path = Path(shutil.copytree(SHIPPED_FOLDER / "librarian", folder)) / "robot.yaml"
    before, _, after = path.read_text(encoding="utf-8").partition("errors:")
    rest = after[after.index("\ntolerance:") :]
    path.write_text(f"{before}errors: {errors}\n{rest}", encoding="utf-8")
    return load_robot(str(path))


@pytest.fixture
def ideal(tmp_path: Path) -> RobotFile:
    """The librarian, its file saying that nothing errs."""
    return librarian(tmp_path / "ideal", "{none: true}")


def test_none_makes_all_errors_zero_also_that_of_the_ranges(ideal: RobotFile) -> None:
    given = ideal.errors.model_dump()
    assert given.pop("none") is True
    given.pop("hand_systematic_wave_m")  # how long the waves are whose height is 0
    assert set(given.values()) == {0.0}
    assert ideal.range_sensor is not None
    assert ideal.range_sensor.sigma_mm == 0.0


def test_errors_that_stand_beside_none_count_as_zero(tmp_path: Path) -> None:
    assert librarian(tmp_path / "a", "{none: true, start_mm: 20}").errors.start_mm == 0.0
    assert librarian(tmp_path / "b", "{none: false, start_mm: 20}").errors.start_mm == 20.0


@pytest.mark.slow
def test_robot_without_errors_reads_the_truth_at_its_start(ideal: RobotFile) -> None:
    for robot in (ideal, load_robot("librarian").without_errors()):
        backend: Any
        other: Any
        with make_backend("kinematic", robot, WORLD, 7) as backend:
            backend.step()
            _, arm, gripper, *_, ranges = backend.capabilities()
            scene = backend.scene
            assert np.array_equal(arm.joints(), scene.joints)
            assert gripper.width() == scene.width
            first = ranges.scan().ranges
            backend.step()
            assert np.array_equal(first, ranges.scan().ranges)
        with make_backend("kinematic", robot, WORLD, 8) as other:
            assert other.scene.base == scene.base


@pytest.mark.parametrize(
    ("variant", "differs"),
    [
        (
            "h1",
            {
                "arm.accuracy_mm",
                "errors.hand_uniform_mm",
                "errors.hand_systematic_mm",
                "errors.hand_repeat_mm",
            },
        ),
        ("uncalibrated", {"errors.camera_mount_mm", "errors.camera_mount_mrad", "errors.focal_percent"}),
    ],
)
def test_variants_of_a_robot_differ_in_what_they_say_alone(variant: str, differs: set[str]) -> None:
    """Each knows how its base gives as far as it was calibrated, `toyama/uncalibrated` not at all."""
    plain, other = (load_robot(name).model_dump() for name in ("toyama", f"toyama/{variant}"))
    found = {
        f"{section}.{key}"
        for section, values in plain.items()
        if isinstance(values, dict) and section != "suspension"
        for key, value in values.items()
        if other[section][key] != value
    }
    assert found == differs
    assert [
        name for name, value in plain.items() if not isinstance(value, dict) and other[name] != value
    ] == []
    assert plain["suspension"] != other["suspension"]
