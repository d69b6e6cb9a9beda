"""Areas of the map whose obstacles are not those of the room: known surfaces, and objects on low ones."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from handcart.primitives.objects.files.surface import ObjectSurface
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.maps.grid_map import GridMap
from handcart.robotics.numerics.arrays import FloatArray

BELOW_M = 0.02  # that the top of a surface is below a lidar which sees over it
OWN_SHARE = 0.5  # of a surface, from which the map's obstacles on it are the surface itself, drawn by hand
SAMPLES = 12  # along each side of a surface, at which the map is read
SQUARE = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])


class KnownSurface(NamedTuple):
    """A surface where the file states it and where it is now, and the objects that are known to be on it."""

    stated: ObjectSurface
    now: ObjectSurface
    feet: Sequence[tuple[float, Pose2 | None]]
    """Radius in [m] of the circle in which each object's foot is, and its middle on the map; None if the
    object may be anywhere on the surface."""


def hiding_areas(surfaces: Sequence[KnownSurface], grid: GridMap, seen_from: float) -> Iterator[FloatArray]:
    """Yield the outlines (n, 2) on the map, in [m], of areas whose obstacles are known bodies.

    They are the surfaces, where the file states them and where they were measured. A lidar that is higher
    than a surface sees over it: the obstacles there are things that stand on it, and only the known objects
    among them are hidden, and the surface's edge, which may have been drawn by hand.

    Args:
        surfaces: known surfaces.
        grid: the map.
        seen_from: height of the lidar, in [m]; 0 without one.
    """
    for surface in surfaces:
        if surface.stated.height_m <= 0.0 and not surface.stated.walls:
            continue  # an area of the floor hides nothing
        places = [(radius, pose) for radius, pose in surface.feet if pose is not None]
        is_known = len(places) == len(surface.feet)
        outlines = surface.stated.outline, surface.now.outline
        if is_known and _is_seen_over(surface.now, seen_from) and not _is_drawn(surface.now, grid):
            for corners in outlines:
                yield from (np.array(side) for side in zip(corners, np.roll(corners, 1, axis=0), strict=True))
            for radius, pose in places:
                yield radius * SQUARE + np.array([pose.x, pose.y])
        else:
            yield from outlines


def _is_seen_over(surface: ObjectSurface, seen_from: float) -> bool:
    is_open = not surface.walls and surface.clearance_m is None
    return is_open and surface.height_m < seen_from - BELOW_M


def _is_drawn(surface: ObjectSurface, grid: GridMap) -> bool:
    """Return whether the map shows most of a surface as an obstacle: it was drawn by hand, or from above."""
    shares = (np.arange(SAMPLES) + 0.5) / SAMPLES * 2.0 - 1.0
    local = np.stack(np.meshgrid(shares, shares), axis=-1).reshape(-1, 2) * (np.array(surface.size_m) / 2)
    points = surface.floor.apply(local)
    cells = grid.to_cell(points[grid.inside(points)])
    return len(cells) > 0 and float(grid.occupied[cells[:, 0], cells[:, 1]].mean()) > OWN_SHARE
