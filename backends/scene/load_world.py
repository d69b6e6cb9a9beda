"""Reading a world's file with the map that it names."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from handcart.backends.map_file import load_map, map_path
from handcart.files.errors import UnsafePath
from handcart.files.loading import Loaded, load_document
from handcart.files.yaml_document import read_document
from handcart.robotics.navigation.grid_map import GridMap
from handcart.robotics.navigation.map_walls import map_walls

from .world_file import Furniture, WorldFile
from .world_model import world_model

HEIGHT = 2.0  # of what stands on a map [m]


def load_world(path: Path) -> WorldFile:
    """What stands in a world: the file, with what its map shows among the furniture.

    Raises:
        FileError: the file, its map or the map's picture is missing, or something in them is wrong.
    """
    return read_world(path)[1]


def read_world(path: Path) -> tuple[Loaded[WorldFile], WorldFile]:
    """The file as it is, with the place of each value, and what `load_world` gives; raises `FileError`."""
    loaded = load_document(read_document(path), world_model())
    world = loaded.value
    if world.map is None:
        return loaded, world
    grid, _ = load_map(_map_path(loaded, world.map))
    return loaded, world.model_copy(update={"furniture": (*world.furniture, *_standing(grid)), "map": None})


def _map_path(loaded: Loaded[WorldFile], name: str) -> Path:
    folder = loaded.document.folder.resolve()
    try:
        path = map_path(folder.parent, name, start=folder)
    except UnsafePath as unsafe:
        raise loaded.refuse(("map",), str(unsafe)) from None
    if not path.is_file():
        allowed = "allowed: a file, from the world's folder"
        raise loaded.refuse(("map",), f"there is no file {name!r}; {allowed}")
    return path


def _standing(grid: GridMap) -> list[Furniture]:
    """What is occupied; made without the checks of a file: a wall may be longer than a hall."""
    walls = map_walls(grid)
    walls[:, 2] = np.degrees(walls[:, 2])
    return [
        Furniture.model_construct(
            name="wall on the map", x_m=x, y_m=y, heading_deg=heading, size_m=(length, width, HEIGHT)
        )
        for x, y, heading, length, width in walls.tolist()
    ]
