"""The section `range_sensor` of a robot's file."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from handcart.backends.description.robot_names import robot_path
from handcart.backends.loading.robot_loading import load_robot
from handcart.files.errors import FileError


def written(folder: Path, keys: str) -> str:
    """The cart's file with other keys in place of its reach."""
    text = robot_path("cart").read_text(encoding="utf-8")
    shutil.copy(robot_path("cart").parent / "cart.urdf", folder)
    path = folder / "robot.yaml"
    path.write_text(text.replace("reach_m: 12.0", keys), encoding="utf-8")
    return str(path)


def test_range_max_m_is_another_name_of_reach_m(tmp_path: Path) -> None:
    spec = load_robot(written(tmp_path, "range_max_m: 8.0")).range_sensor
    assert spec is not None
    assert spec.reach_m == 8.0
    assert spec.is_full_turn
    np.testing.assert_array_equal(spec.angles(), np.linspace(-np.pi, np.pi, 360, endpoint=False))


def test_a_field_of_view_has_beams_at_both_ends(tmp_path: Path) -> None:
    keys = "reach_m: 8.0\n  start_deg: -135\n  end_deg: 135\n  masked_deg: [[-135, -130], [170, -170]]"
    spec = load_robot(written(tmp_path, keys)).range_sensor
    assert spec is not None
    assert np.degrees(spec.angles()[[0, -1]]) == pytest.approx([-135.0, 135.0])
    degrees = np.radians([-131.0, -129.0, 175.0, -175.0, 180.0, -169.0, 535.0])
    assert list(spec.masked(degrees)) == [True, False, True, True, True, False, True]


def test_masked_sector_holds_the_beams_at_its_ends(tmp_path: Path) -> None:
    """Of 271 beams a degree apart, those at 30, 60 and 100 degrees were left out."""
    keys = (
        "reach_m: 8.0\n  start_deg: -135\n  end_deg: 135\n  masked_deg: [[30, 60], [100, 135], [-135, -90]]"
    )
    spec = load_robot(written(tmp_path, keys).replace("beams: 360", "beams: 271")).range_sensor
    assert spec is not None
    degrees = np.arange(-135.0, 136.0)
    inside = ((degrees >= 30) & (degrees <= 60)) | (degrees >= 100) | (degrees <= -90)
    for angles in (
        np.linspace(np.radians(-135.0), np.radians(135.0), 271),
        np.radians(degrees).astype(np.float32),
    ):
        np.testing.assert_array_equal(spec.masked(angles), inside)
    full = spec.model_copy(update={"masked_deg": ((-180.0, 180.0),)})
    assert full.masked(np.radians(degrees)).all()


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ("range_max_m: -1", "allowed: a number above 0"),
        ("reach_m: 5\n  range_max_m: 6", "allowed: one of them"),
        ("reach_m: 5\n  range_min_m: 5", "allowed: less than 5"),
        ("reach_m: 5\n  start_deg: 90\n  end_deg: -90", "allowed: more than 0, up to 360"),
        ("reach_m: 5\n  start_deg: -180\n  end_deg: 181", "allowed: more than 0, up to 360"),
        ("reach_m: 5\n  no_return: [zeros]", "zeros"),
        ("range_min_m: 0.1", "the key 'reach_m' is missing"),
    ],
)
def test_wrong_keys_are_refused_once_with_their_place(tmp_path: Path, keys: str, words: str) -> None:
    with pytest.raises(FileError) as raised:
        load_robot(written(tmp_path, keys))
    assert len(raised.value.findings) == 1
    assert words in str(raised.value)
    assert raised.value.findings[0].line > 1
