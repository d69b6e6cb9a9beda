"""Room of a polygonal footprint along a route, at the heading of travel."""

from __future__ import annotations

import math

import numpy as np

from handcart.robotics.geometry.footprint import Footprint, polygon_distance
from handcart.robotics.navigation.maps.grid_map import GridMap
from handcart.robotics.numerics.arrays import BoolArray, FloatArray
from handcart.robotics.numerics.compiled import compiled

TANGENT_M = 0.08  # of route before and behind a point, over which its heading is taken
TURN_STEP_RAD = 0.1  # at most between two poses that are looked at
MAX_ROOM_M = 0.1  # beyond which room is not measured


def swept_room(
    grid: GridMap, shape: Footprint, points: FloatArray, heading: float | None = None
) -> FloatArray:
    """Return the least room (n,), in [m], between a polygonal robot and blocked cells as it drives along a
    route.

    There is one value for each point of the route; it includes the room for the turn at the point. A blocked
    cell is taken as a disc of the cell's size. The room is negative where the robot would overlap a cell, and
    at most `MAX_ROOM_M`.

    Args:
        grid: the map; unknown cells and everything beyond the map count as blocked.
        shape: polygon of the footprint.
        points: (n, 2) route on the map, in [m].
        heading: heading of the robot before it turns into the route, in [rad]; None: that of the route.
    """
    headings = travel_headings(points)
    before = np.concatenate([[headings[0] if heading is None else heading], headings[:-1]])
    corner = np.array([grid.origin_x, grid.origin_y])
    cells = np.ascontiguousarray((points - corner) / grid.resolution)
    return np.asarray(
        _swept(grid.blocked, shape.corners, shape.radius, cells, before, headings, grid.resolution)
    )


def travel_headings(points: FloatArray) -> FloatArray:
    """Return the heading of travel (n,) at each point of a route, in [rad], unwrapped so that it does not
    jump.

    Args:
        points: (n, 2) points of the route on the map, in [m].
    """
    if len(points) < 2:
        return np.zeros(len(points))
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    ends = [
        [np.interp(along + side, along, points[:, i]) for i in (0, 1)] for side in (-TANGENT_M, TANGENT_M)
    ]
    rays = np.array(ends[1]) - np.array(ends[0])
    return np.asarray(np.unwrap(np.arctan2(rays[1], rays[0])))


@compiled
def _swept(
    blocked: BoolArray,
    corners: FloatArray,
    radius: float,
    cells: FloatArray,
    before: FloatArray,
    headings: FloatArray,
    resolution: float,
) -> FloatArray:
    """Return the room (n,) at positions (n, 2), column and row, while turning between two headings."""
    height, width = blocked.shape
    rooms = np.empty(len(cells))
    reach = math.ceil((radius + MAX_ROOM_M) / resolution) + 1
    for i in range(len(cells)):
        rooms[i] = MAX_ROOM_M
        turn = headings[i] - before[i]
        turn -= 2.0 * math.pi * np.round(turn / (2.0 * math.pi))
        looks = 1 + int(abs(turn) / TURN_STEP_RAD)
        column, row = math.floor(cells[i, 0]), math.floor(cells[i, 1])
        for r in range(row - reach, row + reach + 1):
            for c in range(column - reach, column + reach + 1):
                outside = r < 0 or c < 0 or r >= height or c >= width
                if not outside and not blocked[r, c]:
                    continue
                x, y = (c + 0.5 - cells[i, 0]) * resolution, (r + 0.5 - cells[i, 1]) * resolution
                if math.sqrt(x * x + y * y) > radius + MAX_ROOM_M + 0.5 * resolution:
                    continue
                for k in range(looks):
                    angle = before[i] + turn * (k + 1) / looks
                    cos, sin = math.cos(angle), math.sin(angle)
                    away = polygon_distance(corners, cos * x + sin * y, cos * y - sin * x)
                    rooms[i] = min(rooms[i], away - 0.5 * resolution)
    return rooms
