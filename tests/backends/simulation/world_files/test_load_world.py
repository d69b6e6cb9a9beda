from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest

from handcart.backends.map_world import as_world_file
from handcart.backends.simulation.world.world_file import WorldFile
from handcart.backends.simulation.world_files.load_world import load_world, load_world_or_map
from handcart.files.errors import FileError
from handcart.robotics.geometry.pose2 import Pose2

HEAD = "format: handcart-world/1\nstart: {x_m: 0, y_m: 0}\n"
MAP = "image: map.png\nresolution: 0.1\norigin: [-1.0, 2.0, 0.0]\n"


@pytest.fixture
def read(tmp_path: Path) -> Callable[..., WorldFile]:
    def written(world: str, chart: str = MAP) -> WorldFile:
        picture = np.full((6, 8), 254, dtype=np.uint8)
        picture[0, 2:5] = 0  # the top row in the picture has the highest y
        cv2.imwrite(str(tmp_path / "map.png"), picture)
        (tmp_path / "map.yaml").write_text(chart, encoding="utf-8")
        (tmp_path / "world.yaml").write_text(HEAD + world, encoding="utf-8")
        return load_world(tmp_path / "world.yaml")

    return written


def test_what_is_occupied_on_the_map_stands_among_the_furniture(read: Callable[..., WorldFile]) -> None:
    world = read("map: map.yaml\nfurniture: [{name: box, x_m: 0, y_m: 0, size_m: [1, 1, 1]}]\n")
    box, wall = world.furniture
    assert box.name == "box"
    assert (wall.x_m, wall.y_m, wall.heading_deg) == pytest.approx((-0.65, 2.55, 0.0))
    assert wall.size_m == pytest.approx((0.21, 0.01, 2.0))


@pytest.mark.parametrize(
    "thing",
    [
        "furniture: [{name: counter, x_m: -0.65, y_m: 2.55, size_m: [0.3, 0.1, 0.7]}]",
        "tables: [{name: desk, x_m: -0.65, y_m: 2.55, size_m: [0.8, 0.8, 0.7], foot_m: [0.3, 0.1]}]",
    ],
)
def test_what_the_map_shows_of_a_piece_is_no_wall_above_it(
    read: Callable[..., WorldFile], thing: str
) -> None:
    """Otherwise the arm hits a wall of 2 m that is inside the counter and on no picture."""
    walls = [piece for piece in read(f"map: map.yaml\n{thing}\n").furniture if piece.name != "counter"]
    assert walls == []


def test_walls_below_a_hanging_piece_stay_walls(read: Callable[..., WorldFile]) -> None:
    board = "{name: board, x_m: -0.65, y_m: 2.55, size_m: [0.3, 0.1, 0.1], above_m: 1.0}"
    assert len(read(f"map: map.yaml\nfurniture: [{board}]\n").furniture) == 2


@pytest.mark.parametrize(
    ("world", "chart", "message"),
    [
        ("map: nap.yaml\n", MAP, r"world\.yaml:3:6: missing file 'nap\.yaml'; allowed"),
        ("map: ../../map.yaml\n", MAP, r"world\.yaml:3:6: .*leads out of"),
        ("map: /map.yaml\n", MAP, r"world\.yaml:3:6: .*is absolute"),
        ("map: map.yaml\n", MAP.replace("map.png", "nap.png"), r"map\.yaml:1:8: no picture"),
        ("map: map.yaml\n", MAP.replace("0.0]", ".inf]"), r"map\.yaml:3:21: \.inf is not a finite number"),
    ],
)
def test_a_map_that_cannot_be_read_is_told_with_its_place(
    read: Callable[..., WorldFile], world: str, chart: str, message: str
) -> None:
    with pytest.raises(FileError, match=message):
        read(world, chart)


def test_a_map_in_place_of_a_world_is_the_same_read_and_as_a_file(
    read: Callable[..., WorldFile], tmp_path: Path
) -> None:
    read("")
    start = Pose2(0.25, 2.5, 0.1)
    world = load_world_or_map(tmp_path / "map.yaml", start)
    assert len(world.furniture) == 1
    with as_world_file(tmp_path / "map.yaml", start) as path:
        read_from_file = load_world(path).model_dump(include=set(WorldFile.model_fields))
    assert read_from_file == world.model_dump()
