"""Looks at the floor below the hand, where an object would lie that was let go and not taken."""

from __future__ import annotations

from collections.abc import Generator, Iterator
from typing import Literal

import numpy as np

from handcart.backends.robot.fresh_pictures import Photo
from handcart.backends.robot.robot import Robot
from handcart.primitives.driving.driving import map_with_cells
from handcart.primitives.knowledge.world_model import ModelView
from handcart.primitives.objects.knowledge.objects import Objects
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Measured, NeedsPerson
from handcart.primitives.outcomes.evidence import Evidence
from handcart.primitives.restoring.snapshot import settle
from handcart.robotics.navigation.maps.clearances import Clearances
from handcart.robotics.navigation.maps.map_window import window_around
from handcart.robotics.numerics.arrays import FloatArray
from handcart.robotics.perception.objects.plain_patch import PictureEdges, is_plain

from .object_look import ObjectLook, look_from
from .view_plan import directions

FloorLook = Literal["plain", "patterned"]
FloorSeen = Literal["free", "not seen", "no tag seen"]
"""Result of a look: nothing lies there; no view; nothing was read on a floor that has edges of its own."""
VIEW_DISTANCES_M = (0.8, 0.85, 0.7, 0.9, 0.6)
FALLEN_M = 0.25  # below where it was released, an object fell
PATCH_HALF_M, TILE_M = 0.225, 0.15  # of the floor around where it would fall
STEPS_M = np.arange(-PATCH_HALF_M + TILE_M / 2, PATCH_HALF_M, TILE_M)  # to the middles of its parts
WINDOW_HALF_M = 0.6  # of the map around it
OWN_MARGIN_M = 0.10  # of the floor beside the robot, known surfaces and walls, that they may hide
MIN_SEEN_SHARE = 0.6  # of the parts of the patch that can be judged
MIN_JUDGED_SHARE = 0.5  # of all parts of the patch


def look_at_floor(
    robot: Robot,
    model: ModelView,
    evidence: Evidence,
    name: str,
    released: FloatArray,
    looks: FloorLook,
) -> Generator[None, None, FloorSeen]:
    """Look at the floor below the place where an object was released; return what is known of the floor.

    Args:
        robot: robot with an empty hand.
        model: knows the object.
        evidence: receives the picture.
        name: name of the object.
        released: (3,) position of the object's foot when it was let go, in the base frame, in [m].
        looks: "plain" if anything with an edge on the floor is taken for the object; "patterned" if only the
            object's tags count, because the floor has edges of its own.

    Returns:
        "free" if nothing lies there; "not seen" if too little of the floor was seen, or if an object without
        tags may lie on a patterned floor; "no tag seen" if no tag of the object was read on a patterned
        floor.

    Raises:
        NeedsPerson: the object lies there.
    """
    below, lowest = np.append(released[:2], 0.0), float(released[2]) - FALLEN_M
    look = ObjectLook()
    above = list(directions((), None, "above"))
    if not (yield from look_from(robot, model, below, above, VIEW_DISTANCES_M)):
        return "not seen"
    yield from settle(robot)
    yield from look.picture(robot, model, evidence, name)
    for read in look.of(name):
        assert read.base_T_object is not None
        height = float(read.base_T_object[2, 3])
        if height < lowest:
            low = Measured("Camera", "height of its foot", 1e3 * height, 1e3 * lowest, "mm")
            raise NeedsPerson(f"{name} fell to the floor", low, cause=causes.SLIPPED)
    if looks == "patterned":
        return "no tag seen" if model.of(Objects).objects.tags_of(name) else "not seen"
    yield
    return _checked_free(robot, model, robot.photo(), name, below)


def _checked_free(robot: Robot, model: ModelView, photo: Photo, name: str, below: FloatArray) -> FloorSeen:
    """Return whether the floor around a point (3,) in the base frame, in [m], was seen; it must look plain.

    Raises:
        NeedsPerson: the floor there does not look plain.
    """
    tiles = list(_tiles(robot, model, below))
    edges = PictureEdges.of_picture(photo.pixels)
    shares = [edges.share(photo.camera, photo.base_T_camera, tile) for tile in tiles]
    for share in shares:
        if share is not None and not is_plain(share):
            seen = Measured("Camera", "share of edges on the floor", share, 0.0)
            raise NeedsPerson(
                f"something lies below the hand; {name} may have fallen", seen, cause=causes.SLIPPED
            )
    known = sum(share is not None for share in shares)
    is_enough = len(tiles) >= MIN_JUDGED_SHARE * len(STEPS_M) ** 2 and known >= MIN_SEEN_SHARE * len(tiles)
    return "free" if is_enough else "not seen"


def _tiles(robot: Robot, model: ModelView, below: FloatArray) -> Iterator[FloatArray]:
    """Yield the corners (4, 3) of parts of the floor around a point (3,), both in the base frame in [m].

    Parts that the robot, a surface or an obstacle on the map or sensed by the lidar may hide are left out:
    there, edges are no sign of the object.
    """
    surfaces = model.of(Objects).objects.surfaces.values()
    map_x, map_y = robot.pose.apply(below[None, :2])[0].tolist()
    window = window_around(map_with_cells(model), map_x, map_y, WINDOW_HALF_M)
    obstacles = Clearances(window, window.blocked)
    square = 0.5 * TILE_M * np.array([[1, 1, 0], [-1, 1, 0], [-1, -1, 0], [1, -1, 0]])
    for x, y in ((below[0] + dx, below[1] + dy) for dx in STEPS_M for dy in STEPS_M):
        corners = square + np.array([x, y, 0.0])
        beside = robot.spec.footprint_shape.distances(corners[:, :2]).min()
        on_map = robot.pose.apply(corners[:, :2])
        onto = max(
            (surface.margin(*corner) for surface in surfaces for corner in on_map.tolist()), default=-1.0
        )
        if beside > OWN_MARGIN_M and onto < -OWN_MARGIN_M and _is_mapped_free(obstacles, on_map):
            yield corners


def _is_mapped_free(obstacles: Clearances, corners: FloatArray) -> bool:
    """Return whether a part of the floor with corners (4, 2) on the map, in [m], is away from obstacles."""
    points = np.vstack([corners, corners.mean(axis=0)])
    return bool(obstacles.at(points).min() > OWN_MARGIN_M)
