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


def test_area_of_a_door_is_what_its_leaf_sweeps() -> None:
    doors = load(TASK / "doors.yaml", DoorsFile).doors
    drawer, cupboard = doors["drawer"].movable_area(), doors["cupboard"].movable_area()
    assert (drawer.low, drawer.high) == pytest.approx((0.75, 0.95))
    assert drawer.outline.min(axis=0) == pytest.approx((4.045 - 0.4, 0.8), abs=1e-3)  # it opens towards -x
    assert drawer.outline.max(axis=0) == pytest.approx((4.045 + 0.02, 1.2), abs=1e-3)
    low, high = cupboard.outline.min(axis=0), cupboard.outline.max(axis=0)
    hinge = 3.0 + (0.6**2 - 0.045**2) ** 0.5  # left of somebody who looks along +x
    assert (low[1], high[0]) == pytest.approx((2.94, 3.945 + 0.02), abs=1e-3)  # closed
    assert low[0] == pytest.approx(3.9 - (hinge - 2.94), abs=0.05)  # open at 90 degrees
    assert high[1] == pytest.approx(hinge, abs=0.05)


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
