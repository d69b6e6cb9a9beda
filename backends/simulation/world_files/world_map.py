"""The map of a simulated world, as a lidar at a given height would survey it."""

from __future__ import annotations

import numpy as np

from handcart.backends.simulation.world.solids import Solid
from handcart.backends.simulation.world.world_file import Surprise, WorldFile
from handcart.backends.simulation.world_files.world_findings import solids_of
from handcart.files.errors import InputError
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.maps.grid_map import GridMap, from_boxes

MARGIN_M = 0.2  # of free cells around everything that is shown
MAX_CELLS = 25_000_000  # of one map, as a picture of 5000 by 5000 pixels


class NoMap(InputError):
    """Error for a world of which no map can be drawn, as it is empty at the map's height or too large."""


def map_of_world(world: WorldFile, height: float, resolution: float) -> GridMap:
    """Return the occupancy grid of the solids in a world that intersect the level plane at a height.

    Surprises, obstacles unknown to the robot, are excluded.

    Args:
        world: the world, as `load_world` returns it.
        height: height of the plane above the floor, in [m].
        resolution: side of a cell, in [m].

    Raises:
        NoMap: nothing cuts the plane, or the map would have more than `MAX_CELLS` cells.
    """
    shown = shown_solids(world, height)
    if not shown:
        raise NoMap(
            f"nothing in the world cuts the plane {height:g} m above the floor; allowed: a height at "
            "which it has walls, furniture or feet of tables"
        )
    low, high = _bounds(shown)
    origin = np.floor((low - MARGIN_M) / resolution + 1e-6) * resolution
    size = high + MARGIN_M - origin
    cells = float(np.prod(np.ceil(size / resolution)))
    if cells > MAX_CELLS:
        raise NoMap(
            f"a map with cells of {resolution:g} m would have {cells:.2g} cells; allowed: "
            f"{MAX_CELLS:.2g} cells at most, so a coarser resolution"
        )
    corner = round(float(origin[0]), 6), round(float(origin[1]), 6)
    return from_boxes(
        (solid.outline for solid in shown), resolution, corner, (float(size[0]), float(size[1]))
    )


def shown_solids(world: WorldFile, height: float) -> list[Solid]:
    """Return the solids of a world that a map drawn at a height above the floor, in [m], shows.

    These are the solids that intersect the plane, without surprises (obstacles that no map shows).
    """
    surprises = {surprise.name for surprise in world.surprises if isinstance(surprise, Surprise)}
    return [solid for solid in solids_of(world) if solid.box.name not in surprises and solid.reaches(height)]


def _bounds(solids: list[Solid]) -> tuple[np.ndarray, np.ndarray]:
    """Return the least and the largest x and y of all solids, (2,) each in [m]."""
    corners = []
    for x, y, yaw, length, width in (solid.outline for solid in solids):
        half = np.array([[1, 1], [1, -1]]) * (length / 2, width / 2)
        turned = [Pose2(0.0, 0.0, yaw).apply(corner) for corner in half]
        corners += [np.array([x, y]) + sign * corner for corner in turned for sign in (-1, 1)]
    return np.min(corners, axis=0), np.max(corners, axis=0)
