"""Doors and drawers of a world's file."""

from __future__ import annotations

from pathlib import Path

import pytest

from handcart.backends.simulation.world_files.load_world import load_world
from handcart.files.errors import FileError

HANDLE = "handle: {x_m: 2, y_m: 0, height_m: 1.0}"


def written(folder: Path, keys: str) -> Path:
    path = folder / "world.yaml"
    path.write_text(
        "format: handcart-world/1\nstart: {x_m: 0, y_m: 0}\n"
        f"doors:\n  - {{name: closet, {HANDLE}, {keys}}}\n",
        encoding="utf-8",
    )
    return path


@pytest.mark.parametrize(
    ("keys", "wrong"),
    [
        ("radius_m: 0.7, travel_deg: 60, opened_deg: 120", "opened_deg 120; allowed: 0 to 60 deg"),
        ("radius_m: 0.7, jams_deg: 30, opened_deg: 40", "opened_deg 40; allowed: 0 to 30 deg"),
        ("radius_m: 0.7, locked: true, opened_deg: 91", "opened_deg 91; allowed: 0 to 90 deg"),
        ("motion: sliding, opened_mm: 401", "opened_mm 401; allowed: 0 to 400 mm"),
    ],
)
def test_a_door_that_starts_beyond_its_stop_is_refused(tmp_path: Path, keys: str, wrong: str) -> None:
    with pytest.raises(FileError, match=wrong):
        load_world(written(tmp_path, keys))


@pytest.mark.parametrize(
    "keys",
    [
        "radius_m: 0.7, travel_deg: 60, opened_deg: 60",
        "radius_m: 0.7, locked: true, opened_deg: 45",
        "motion: sliding, jams_mm: 150, opened_mm: 150",
    ],
)
def test_a_door_may_start_at_its_stop(tmp_path: Path, keys: str) -> None:
    (door,) = load_world(written(tmp_path, keys)).model_dump()["doors"]
    assert f"{door['opened_deg'] or door['opened_mm']:g}" == keys.split()[-1]
