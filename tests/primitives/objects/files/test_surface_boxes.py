"""Bodies of surfaces that the arm keeps clear of: boards, walls and what is above them."""

from __future__ import annotations

from pathlib import Path

import pytest

from handcart.files.errors import FileError
from handcart.files.models.loading import load
from handcart.primitives.objects.files.objects_file import ObjectsFile
from handcart.primitives.objects.files.surface import ObjectSurface
from handcart.robotics.kinematics.shapes import corners


def extents(surface: ObjectSurface) -> list[tuple[list[float], list[float]]]:
    """Return the lower and upper corner of each body, rounded to mm."""
    bodies = [corners(box) for box in surface.boxes("shelf")]
    return [(body.min(axis=0).round(3).tolist(), body.max(axis=0).round(3).tolist()) for body in bodies]


def test_table_is_solid_down_to_the_floor() -> None:
    table = ObjectSurface(x_m=0.0, y_m=0.0, height_m=0.7, size_m=(1.0, 0.6))
    assert extents(table) == [([-0.5, -0.3, 0.0], [0.5, 0.3, 0.7])]


def test_board_has_room_below_it() -> None:
    board = ObjectSurface(x_m=0.0, y_m=0.0, height_m=0.7, size_m=(1.0, 0.6), thickness_m=0.04)
    assert extents(board) == [([-0.5, -0.3, 0.66], [0.5, 0.3, 0.7])]


def test_walls_of_a_shelf_reach_from_the_floor_to_its_ceiling() -> None:
    shelf = ObjectSurface(
        x_m=0.0, y_m=0.0, height_m=0.7, size_m=(1.0, 0.6), clearance_m=0.5, walls=("-x", "+y")
    )
    left, back = extents(shelf)[2:]
    assert left == ([-0.52, -0.3, 0.0], [-0.5, 0.32, 1.24])  # to the corner
    assert back == ([-0.5, 0.3, 0.0], [0.5, 0.32, 1.24])


def test_walls_of_a_box_have_their_own_height() -> None:
    box = ObjectSurface(x_m=0.0, y_m=0.0, height_m=0.01, size_m=(0.5, 0.4), walls=("+x",), wall_m=0.2)
    assert extents(box)[1] == ([0.25, -0.2, 0.0], [0.27, 0.2, 0.21])


def test_walls_without_a_height_are_refused_at_their_line(tmp_path: Path) -> None:
    path = tmp_path / "objects.yaml"
    path.write_text(
        "format: handcart-objects/1\nkinds: {}\nsurfaces:\n"
        '  bin: {x_m: 0, y_m: 0, height_m: 0.1, size_m: [1, 1], walls: ["+x"]}\n',
        encoding="utf-8",
    )
    with pytest.raises(FileError, match=r":4:\d+: .*walls without a height; allowed: wall_m, or clearance_m"):
        load(path, ObjectsFile)


def test_walls_are_thickened_on_both_faces_by_the_room() -> None:
    box = ObjectSurface(x_m=0.0, y_m=0.0, height_m=0.01, size_m=(0.5, 0.4), walls=("-y",), wall_m=0.2)
    bottom, wall = (corners(body) for body in box.boxes("box", room=0.01))
    assert (bottom.min(axis=0)[1], bottom.max(axis=0)[1]) == pytest.approx((-0.2, 0.2))
    assert (wall.min(axis=0)[1], wall.max(axis=0)[1]) == pytest.approx((-0.23, -0.19))
