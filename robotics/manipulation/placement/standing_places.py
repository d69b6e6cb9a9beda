"""Poses that a base can occupy: clear of obstacles, and with a route to them."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from scipy import ndimage

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.kinematics.coal_bodies import coal_body
from handcart.robotics.kinematics.libraries import pin
from handcart.robotics.kinematics.shapes import Shape, radius_about
from handcart.robotics.navigation.maps.grid_map import GridMap
from handcart.robotics.numerics.arrays import BoolArray, FloatArray


class OpenFloor:
    """Connected areas of a map in which a round base can move freely; no route leads from one area to
    another.
    """

    def __init__(self, grid: GridMap, radius: float) -> None:
        """Divide a map.

        Args:
            grid: the map.
            radius: of the base, in [m]; its centre keeps that far from occupied and unknown cells, and from
                the edge of the map.
        """
        free = np.pad(~grid.blocked, 1).astype(np.uint8)
        away = cv2.distanceTransform(free, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)[1:-1, 1:-1] * grid.resolution
        self._grid = grid
        self._rooms, _ = ndimage.label(away >= radius, structure=np.ones((3, 3)))

    def reached_from(self, start: tuple[float, float]) -> BoolArray:
        """Return a mask (h, w), True for cells of the map that a base can drive to from a place.

        Row 0 has the lowest y.

        Args:
            start: x and y on the map, in [m]; off the map nothing is reached.
        """
        if not self._grid.inside(np.array([start]))[0]:
            return np.zeros(self._rooms.shape, dtype=np.bool_)
        home = self._rooms[tuple(self._grid.to_cell(np.array([start]))[0])]
        return np.asarray((self._rooms == home) & (home != 0))

    def leads_to(self, bases: FloatArray, reached: BoolArray) -> BoolArray:
        """Return a mask (b,), True for base poses on cells that the base can drive to.

        Args:
            bases: (b, 3) map_T_base: x, y in [m], heading in [rad].
            reached: (h, w) mask of the map's cells that the base can drive to, from `reached_from`.
        """
        inside = self._grid.inside(bases[:, :2])
        cells = self._grid.to_cell(bases[inside, :2])
        found = np.zeros(len(bases), dtype=np.bool_)
        found[inside] = reached[cells[:, 0], cells[:, 1]]
        return found


def stands_clear(
    bases: FloatArray, bodies: Sequence[Shape], obstacles: Sequence[Shape], margin: float = 0.0
) -> BoolArray:
    """Return a mask (b,), True for base poses at which all bodies of the robot are clear of obstacles.

    The check is three-dimensional, by the library coal: a base may be below an obstacle that hangs high
    enough.

    Args:
        bases: (b, 3) world_T_base on the floor: x and y in [m], heading in [rad].
        bodies: bodies of the robot, posed in the frame of its base, in its driving posture.
        obstacles: obstacles, posed in world.
        margin: minimum distance, in [m].
    """
    clear = np.ones(len(bases), dtype=np.bool_)
    for body in bodies:
        geometry, around = coal_body(body), radius_about(body) + margin
        centres = _positions(bases, body)
        for obstacle in obstacles:
            fixed, placed = coal_body(obstacle), _placement(obstacle.pose)
            gaps = np.linalg.norm(centres - obstacle.pose[:3, 3], axis=1)
            for index in np.flatnonzero(clear & (gaps < around + radius_about(obstacle))):
                world_T_body = _placement(Pose2(*bases[index]).lift() @ body.pose)
                request, result = pin.coal.CollisionRequest(), pin.coal.CollisionResult()
                request.security_margin = max(margin, _TOUCH)
                pin.coal.collide(geometry, world_T_body, fixed, placed, request, result)
                clear[index] = not result.isCollision()
    return clear


_TOUCH = 1e-6  # [m] coal calls overlapping bodies free at margin 0


def _placement(pose: FloatArray) -> object:
    return pin.coal.Transform3s(pose[:3, :3], pose[:3, 3])


def _positions(bases: FloatArray, body: Shape) -> FloatArray:
    """Return the body's origin (b, 3) in world, in [m], with the base at each of its poses (b, 3)."""
    cos, sin = np.cos(bases[:, 2]), np.sin(bases[:, 2])
    x, y, z = body.pose[:3, 3]
    return np.column_stack(
        (bases[:, 0] + cos * x - sin * y, bases[:, 1] + sin * x + cos * y, np.full(len(bases), z))
    )
