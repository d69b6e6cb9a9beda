"""Files of doors, and what is wrong in them."""

from __future__ import annotations

from pathlib import Path

import pytest

from handcart.files.errors import FileError
from handcart.files.models.loading import load
from handcart.primitives.doors.doors_file import DoorsFile

from .door_rig import TASK, changed


def test_shipped_file_is_read() -> None:
    doors = load(TASK / "doors.yaml", DoorsFile).doors
    assert doors["cupboard"].is_hinged and not doors["drawer"].is_hinged


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("hinge: left", "hinge: lef", "left"),
        ("radius_m: 0.6", "radius_m: 9", "radius_m"),
        ("id: 22", "id: 21", "is on 'drawer' and on 'cupboard'"),
        ("    tags: [{id: 21, side_mm: 50, up_mm: 60}]\n", "", "tags"),
        ("bar: horizontal}", "bar: horizontal, standoff_mm: 20}", "no room for fingers"),
    ],
)
def test_faulty_file_is_refused_at_its_line(tmp_path: Path, old: str, new: str, message: str) -> None:
    path = changed(tmp_path, "doors.yaml", (old, new))
    with pytest.raises(FileError, match=r"doors.yaml:[0-9]+:[0-9]+: ") as error:
        load(path, DoorsFile)
    assert message in str(error.value)
