"""Worlds of `people`: offices and corridors with people who walk about in them, by a seed."""

from __future__ import annotations

import math
from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np

from benchmarks.driving.worlds.office_map import Boxes, office_boxes, wall_boxes
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.maps.grid_map import GridMap, from_boxes
from handcart.robotics.navigation.routes.shortcuts import path_length
from handcart.robotics.navigation.routes.ways import Ways
from handcart.robotics.numerics.arrays import FloatArray

CELL_M = 0.05
PERSON_ROOM_M = 0.3  # beside the middle of a person's way
WALK_LENGTH_M = 4.0  # of a person's way, at least
DRIVE_LENGTH_M = 8.0  # of the robot's way, at least
AWAY_FROM_START_M = 2.0  # where people are at first
OFFICE_M = (20.0, 13.5)
CORRIDOR_LENGTH_M, CORRIDOR_WIDTHS_M = 24.0, (2.2, 3.2)
MAX_TRIES = 500
KINDS = ("office", "corridor")


class Person(NamedTuple):
    """Person who walks to and fro."""

    points: FloatArray
    """(n, 2) waypoints in [m]."""
    pauses: list[float]
    """Time at each, in [s]."""


class PeopleWorld(NamedTuple):
    """A floor with people on it."""

    seed: int
    kind: str
    boxes: Boxes
    grid: GridMap
    start: Pose2
    goal: Pose2
    best_m: float
    """Length of the best way without people, in [m]."""
    people: list[Person]


def people_world(seed: int, count: int, radius: float) -> PeopleWorld:
    """Return a world; kinds alternate.

    Args:
        seed: of everything that is drawn.
        count: number of people.
        radius: radius of the robot's footprint, in [m].
    """
    rng, kind = np.random.default_rng(seed), KINDS[seed % len(KINDS)]
    boxes, size = _office(seed) if kind == "office" else _corridor(rng)
    grid = from_boxes(boxes, CELL_M, (0.0, 0.0), size)
    for _ in range(MAX_TRIES):
        start = _somewhere(rng, size)
        ways = Ways(grid, radius, start)
        goal = _somewhere(rng, size)
        route = ways.to(goal).route
        has_room = _room_at(grid, start) > radius + 0.2 and _room_at(grid, goal) > radius + 2.0 * CELL_M
        if has_room and route is not None and path_length(route.points) >= DRIVE_LENGTH_M:
            break
    else:
        raise RuntimeError(f"no drive in world {seed}")
    first = route.points[min(3, len(route.points) - 1)] - route.points[0]
    start = Pose2(start.x, start.y, math.atan2(first[1], first[0]))
    people = [_person(rng, grid, size, kind, start) for _ in range(count)]
    return PeopleWorld(seed, kind, boxes, grid, start, goal, path_length(route.points), people)


def _office(seed: int) -> tuple[Boxes, tuple[float, float]]:
    return office_boxes(seed, OFFICE_M), OFFICE_M


def _corridor(rng: np.random.Generator) -> tuple[Boxes, tuple[float, float]]:
    size = CORRIDOR_LENGTH_M, float(rng.uniform(*CORRIDOR_WIDTHS_M))
    return wall_boxes(size), size


def _somewhere(rng: np.random.Generator, size: tuple[float, float]) -> Pose2:
    x, y = rng.uniform((0.6, 0.6), (size[0] - 0.6, size[1] - 0.6))
    return Pose2(float(x), float(y), float(rng.uniform(-math.pi, math.pi)))


def _person(
    rng: np.random.Generator, grid: GridMap, size: tuple[float, float], kind: str, start: Pose2
) -> Person:
    """Return a person who walks between two places, along routes through doors."""
    for _ in range(MAX_TRIES):
        begin, end = _somewhere(rng, size), _somewhere(rng, size)
        if begin.distance(start) < AWAY_FROM_START_M or begin.distance(end) < WALK_LENGTH_M:
            continue
        if kind == "corridor":
            points = np.array([begin[:2], end[:2]])
        else:
            route = Ways(grid, PERSON_ROOM_M, begin).to(end).route
            if route is None:
                continue
            points = _thinned(route.points)
        if _room(grid, points) < PERSON_ROOM_M - CELL_M:
            continue
        pauses = np.where(rng.random(len(points)) < 0.2, rng.uniform(0.5, 3.0, len(points)), 0.0)
        return Person(points, [round(float(pause), 2) for pause in pauses])
    raise RuntimeError("nobody finds a way")


def _room_at(grid: GridMap, pose: Pose2) -> float:
    """Return the least distance of a place from the centres of occupied cells, in [m]."""
    return _room(grid, np.array([pose[:2], (pose.x + CELL_M, pose.y)]))


def _room(grid: GridMap, points: FloatArray) -> float:
    """Return the least distance of a way (n, 2) from the centres of occupied cells, in [m]."""
    away = cv2.distanceTransform((~grid.occupied).astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))])
    at = np.arange(0.0, along[-1], CELL_M)
    cells = grid.to_cell(np.column_stack([np.interp(at, along, points[:, i]) for i in (0, 1)]))
    return float(away[cells[:, 0], cells[:, 1]].min()) * grid.resolution


def _thinned(points: FloatArray) -> FloatArray:
    """Return few points of a route (n, 2), within 5 cm of it."""
    closed = cv2.approxPolyDP(points.astype(np.float32)[:, None], 0.05, False)[:, 0]
    return np.asarray(closed, dtype=np.float64)


def write_people_world(world: PeopleWorld, folder: Path, speed: float, body: str, yields: bool) -> None:
    """Write map, world and places of a world into a folder; people walk at a speed in [m/s]."""
    grid = world.grid
    cv2.imwrite(str(folder / "map.png"), np.where(grid.occupied, 0, 254).astype(np.uint8)[::-1])
    (folder / "map.yaml").write_text(
        f"image: map.png\nresolution: {grid.resolution}\norigin: [0, 0, 0]\n"
        "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"
    )
    lines = ["format: handcart-world/1", f"start: {_pose(world.start)}", "furniture:"]
    lines += [
        f"  - {{name: box {i}, x_m: {x:.4f}, y_m: {y:.4f}, heading_deg: {math.degrees(yaw):.4f}, "
        f"size_m: [{length:.4f}, {width:.4f}, 2.0]}}"
        for i, (x, y, yaw, length, width) in enumerate(world.boxes)
    ]
    lines.append("passers:")
    for i, person in enumerate(world.people):
        points = ", ".join(f"[{x:.3f}, {y:.3f}]" for x, y in person.points.tolist())
        lines.append(
            f"  - {{name: person {i}, speed_m_s: {speed}, body: {body}, yields: {str(yields).lower()}, "
            f"waypoints_m: [{points}], pauses_s: {person.pauses}}}"
        )
    (folder / "world.yaml").write_text("\n".join(lines) + "\n")
    (folder / "places.yaml").write_text(
        f"format: handcart-places/1\nplaces:\n  home: {_pose(world.start)}\n  goal: {_pose(world.goal)}\n"
    )


def _pose(pose: Pose2) -> str:
    return f"{{x_m: {pose.x:.4f}, y_m: {pose.y:.4f}, heading_deg: {math.degrees(pose.theta):.4f}}}"
