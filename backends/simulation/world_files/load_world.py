"""Reading a world's file with the map that it names."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from handcart.backends.simulation.world.world_file import Furniture, WorldFile, floor_pose
from handcart.files.errors import UnsafePath
from handcart.files.maps.map_file import is_map_file, load_map, map_path
from handcart.files.models.loading import Loaded, load_document
from handcart.files.printable import printable
from handcart.files.yaml.yaml_document import read_document
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.maps.drawn_boxes import without_drawn_boxes
from handcart.robotics.navigation.maps.grid_map import FloorBox, GridMap
from handcart.robotics.navigation.maps.map_walls import map_walls

from .world_model import world_model

MAP_WALL_HEIGHT_M = 2.0  # height of everything on a map [m]


def load_world(path: Path) -> WorldFile:
    """Return a world's file, with the occupied cells of its map added to the furniture.

    Raises:
        FileError: the file, its map or the map's picture is missing or invalid.
    """
    return read_world(path)[1]


def load_world_or_map(path: Path, start: Pose2) -> WorldFile:
    """Return the world of a world's file, or, given a map's file, a world made of that map's occupied cells.

    In a world made of a map, the robot is at `start` (world_T_base).

    Raises:
        FileError: the file, or a map's picture, is missing or invalid.
    """
    if not is_map_file(path):
        return load_world(path)
    return on_the_map(WorldFile(format="handcart-world/1", start=floor_pose(start)), load_map(path)[0])


def read_world(path: Path) -> tuple[Loaded[WorldFile], WorldFile]:
    """Return a world's file with line and column of each value, and the world to simulate, with its map's
    obstacles.

    Raises:
        FileError: the file is invalid.
    """
    loaded = load_document(read_document(path), world_model())
    world = loaded.value
    if world.map is None:
        return loaded, world
    return loaded, on_the_map(world, load_map(_map_path(loaded, world.map))[0])


def on_the_map(world: WorldFile, grid: GridMap) -> WorldFile:
    """Return a copy of a world with the occupied cells of a map as additional furniture.

    Cells that show a table or a piece of furniture of the world are left out: its height is known.
    """
    walls = _standing(without_drawn_boxes(grid, _boxes_on_floor(world)))
    return world.model_copy(update={"furniture": (*world.furniture, *walls), "map": None})


def _boxes_on_floor(world: WorldFile) -> list[FloorBox]:
    """Return what stands on the floor of a world, as a lidar near the floor sees it."""
    pieces = [(piece, piece.size_m[:2]) for piece in world.furniture if piece.above_m == 0.0]
    feet = [(table, table.foot_m) for table in world.tables]
    return [
        FloorBox(item.x_m, item.y_m, math.radians(item.heading_deg), *size) for item, size in (*pieces, *feet)
    ]


def _map_path(loaded: Loaded[WorldFile], name: str) -> Path:
    folder = loaded.document.folder.resolve()
    try:
        path = map_path(folder.parent, name, start=folder)
    except UnsafePath as unsafe:
        raise loaded.refuse(("map",), str(unsafe)) from None
    if not path.is_file():
        allowed = f"allowed: a file in the world's folder, {printable(str(folder))}"
        raise loaded.refuse(("map",), f"missing file {name!r}; {allowed}")
    return path


def _standing(grid: GridMap) -> list[Furniture]:
    """Return the occupied cells as furniture, without a file's checks, because a wall may be longer than a
    hall.
    """
    walls = map_walls(grid)
    walls[:, 2] = np.degrees(walls[:, 2])
    return [
        Furniture.model_construct(
            name="wall on the map",
            x_m=x,
            y_m=y,
            heading_deg=heading,
            size_m=(length, width, MAP_WALL_HEIGHT_M),
        )
        for x, y, heading, length, width in walls.tolist()
    ]
