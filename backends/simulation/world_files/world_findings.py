"""What is wrong between a world, the robot that is put into it, and the map that it is given."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

import cv2
import numpy as np

from handcart.backends.simulation.world.solids import MIN_BODY_HEIGHT_M, FloorPlan, Solid, room_of
from handcart.files.suggest import suggest
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.maps.grid_map import GridMap, from_boxes

from .passer_findings import passer_findings
from .world_model import kinds_of_props

if TYPE_CHECKING:
    from handcart.backends.description.robot_file import RobotFile
    from handcart.backends.simulation.world.world_file import WorldFile
    from handcart.files.errors import Finding
    from handcart.files.models.loading import Loaded

MAX_SIGMAS = 5.0
ASTRAY_M = 0.3  # between the robot's true and stated start: scan matching corrects that much
ASTRAY_DEG = 15.0
MAX_MAP_DISTANCE_M = 0.3  # [m] from the map's surfaces to those of the world
MIN_MAP_SHARE = 0.5  # of the map's surfaces must exist in a world that has its own file


def world_findings(
    loaded: Loaded[WorldFile],
    world: WorldFile,
    robot: RobotFile,
    initial_pose: Pose2 | None,
    grid: GridMap | None,
) -> Iterator[Finding]:
    """Yield faults of a world that spoil the start of a run, such as a robot that starts inside a wall.

    Args:
        loaded: the world's file.
        world: the same world, with the solids of its map.
        robot: robot that starts in this world.
        initial_pose: initial map_T_base that is given to the robot; None if the robot is given no pose.
        grid: the map that the robot is given; None if the robot is given no map.
    """
    solids = solids_of(world)
    yield from _stands_on(loaded, robot, solids)
    yield from passer_findings(loaded, robot, solids)
    yield from _unknown_beacons(loaded, robot)
    for kind in kinds_of_props().values():
        if isinstance(world, kind.section):
            yield from kind.findings(loaded, robot)
    if initial_pose is not None and not loaded.value.misplaced:
        yield from _elsewhere(loaded, robot, initial_pose)
    if grid is not None and grid.occupied.any():
        yield from _off_its_map(loaded, grid, solids)


def solids_of(world: WorldFile) -> list[Solid]:
    """Return all solids in a world, including those of application domains and surprises (obstacles that no
    map shows).
    """
    kinds = kinds_of_props().values()
    solids = room_of(world)
    return solids + [
        solid for kind in kinds if isinstance(world, kind.section) for solid in kind.solids(world)
    ]


def _stands_on(loaded: Loaded[WorldFile], robot: RobotFile, solids: list[Solid]) -> Iterator[Finding]:
    start, shape = loaded.value.start, robot.footprint_shape
    plan = FloorPlan(solids, MIN_BODY_HEIGHT_M, robot.body_height)
    base = Pose2(start.x_m, start.y_m, math.radians(start.heading_deg))
    gap, name = plan.gap(base, shape, 0.0)
    if gap < 0.0 and shape.is_disc:
        where = f"{name} stands where the robot starts: {gap + shape.radius:.2f} m from its middle"
        yield loaded.finding(("start",), f"{where}; allowed: beyond its footprint, {shape.radius:.2f} m")
    elif gap < 0.0:
        where = f"{name} stands where the robot starts: {-gap:.2f} m inside its footprint"
        yield loaded.finding(("start",), f"{where}; allowed: beyond it")


def _unknown_beacons(loaded: Loaded[WorldFile], robot: RobotFile) -> Iterator[Finding]:
    """Yield a finding for each moved beacon that the robot does not hear; a robot without beacons hears
    none.
    """
    if robot.beacons is None:
        return
    known = robot.beacons.places_m
    for name in loaded.value.beacons.places_m:
        if name not in known:
            wrong = f"unknown beacon {name!r}{suggest(name, known)}"
            yield loaded.finding(("beacons", "places_m", name), wrong, at_key=True)


def _elsewhere(loaded: Loaded[WorldFile], robot: RobotFile, initial_pose: Pose2) -> Iterator[Finding]:
    start = loaded.value.start
    away = math.hypot(start.x_m - initial_pose.x, start.y_m - initial_pose.y)
    turned = abs(math.remainder(start.heading_deg - math.degrees(initial_pose.theta), 360.0))
    most = ASTRAY_M + MAX_SIGMAS * robot.errors.start_mm / 1e3
    widest = ASTRAY_DEG + MAX_SIGMAS * robot.errors.start_deg
    if away > most or turned > widest:
        there = f"({initial_pose.x:.2f}, {initial_pose.y:.2f}) m, {math.degrees(initial_pose.theta):.0f} deg"
        wrong = f"the robot is put {away:.2f} m and {turned:.0f} deg from where it is told to start, {there}"
        yield loaded.finding(
            ("start",), f"{wrong}; allowed: {most:.2f} m, {widest:.0f} deg, or misplaced: true"
        )


def _off_its_map(loaded: Loaded[WorldFile], grid: GridMap, solids: list[Solid]) -> Iterator[Finding]:
    start = loaded.value.start
    if not grid.inside(np.array([[start.x_m, start.y_m]]))[0]:
        yield loaded.finding(("start",), "the robot starts off the map that it is given; allowed: on it")
        return
    share = _alike(grid, solids)
    if share < MIN_MAP_SHARE:
        wrong = f"only {share:.0%} of the robot's map is found in this world (within {MAX_MAP_DISTANCE_M} m)"
        yield loaded.finding(
            (), f"{wrong}; allowed: {MIN_MAP_SHARE:.0%} at least, of a world and its own map"
        )


def _alike(grid: GridMap, solids: list[Solid]) -> float:
    """Return the share of the occupied cells, 0 to 1, with a solid of the world near them."""
    shape = grid.occupied.shape
    size = shape[1] * grid.resolution, shape[0] * grid.resolution
    boxes = [solid.outline for solid in solids]
    stands = from_boxes(boxes, grid.resolution, (grid.origin_x, grid.origin_y), size).occupied
    away = cv2.distanceTransform((~stands).astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    near = away[: shape[0], : shape[1]] * grid.resolution <= MAX_MAP_DISTANCE_M + grid.resolution
    return float(np.mean(near[grid.occupied]))
