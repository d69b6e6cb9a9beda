"""Random rooms with their maps, for `near_walls`: walls, a door, boxes, some of them on no map."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np

from handcart.backends.description.robot_names import SHIPPED_FOLDER
from handcart.backends.loading.robot_loading import load_robot
from handcart.robotics.navigation.maps.grid_map import GridMap, from_boxes
from handcart.robotics.numerics.arrays import FloatArray

CELL_SIZES_M = (0.05, 0.05, 0.1, 0.15, 0.2, 0.25)  # [m]
ROOM, FINE, UNSURE = 0.04, 0.05, 0.5  # what `check` asks for; see handcart.robotics.navigation.routes.ways
MAX_TRIES = 4000
WALL_M = 0.1  # [m] thick
UNMAPPED_BOX_PERIOD = 5  # every so many worlds hold boxes that aren't on the map
Box = tuple[float, float, float, float, float, float]
"""x, y, yaw, length, width, height, in [m] and [rad]."""


class Body(NamedTuple):
    """Name of a robot, and the radius of its footprint [m]."""

    robot: str
    radius: float


ROBOT_BODIES = (
    Body("cart", 0.34),
    Body("cart", 0.2),
    Body("cart", 0.27),
    Body("cart", 0.45),
    Body("librarian", 0.34),
    Body("atrv", 0.53),
)


class Room:
    """A random room with its map, and the free points of it."""

    def __init__(self, seed: int) -> None:
        self.seed = seed
        self.rng = np.random.default_rng(seed)
        self.cell = float(self.rng.choice(CELL_SIZES_M))
        self.body = ROBOT_BODIES[int(self.rng.integers(len(ROBOT_BODIES)))]
        self.width, self.depth = self.rng.uniform(4.0, 6.0, 2) + 2.0 * self.body.radius
        self.boxes = [*self._walls(), *self._things()]
        size = (self.width + 0.6, self.depth + 0.6)
        offset = -0.3 - self.cell * self.rng.random(2)
        flat = [box[:5] for box in self.boxes]
        self.grid: GridMap = from_boxes(flat, self.cell, (float(offset[0]), float(offset[1])), size)
        rows, columns = np.nonzero(self.grid.occupied)
        self._low = np.column_stack([columns, rows]) * self.cell + offset
        self.surprises = self._surprises() if seed % UNMAPPED_BOX_PERIOD == UNMAPPED_BOX_PERIOD - 1 else []

    @property
    def least(self) -> float:
        """Least distance from a place to an obstacle that `check` requires [m]."""
        return self.body.radius + ROOM + UNSURE * max(0.0, self.cell - FINE)

    def clearance(self, points: FloatArray) -> FloatArray:
        """Distance (n,) of points (n, 2) to the squares of occupied cells, each looked at, in [m]."""
        beyond = self._low[None] - points[:, None], points[:, None] - self._low[None] - self.cell
        nearest: FloatArray = np.hypot(*np.maximum(np.maximum(*beyond), 0.0).transpose(2, 0, 1)).min(axis=1)
        return nearest

    def start(self) -> tuple[float, float]:
        """Somewhere with room."""
        for point in self._points(MAX_TRIES):
            if self.clearance(point[None])[0] > self.body.radius + 0.25:
                return float(point[0]), float(point[1])
        raise RuntimeError(f"no start in world {self.seed}")

    def beside(self, room: float) -> Iterator[tuple[float, float]]:
        """Points that leave this much room, in [m]: moved there from somewhere, down to what is nearest."""
        for point in self._points(MAX_TRIES):
            turn = self.rng.uniform(0.0, 2.0 * math.pi)
            ray = np.array([math.cos(turn), math.sin(turn)])
            line = point + np.linspace(0.0, 2.5, 80)[:, None] * ray
            rooms = self.clearance(line)
            below = np.flatnonzero(rooms < room)
            if len(below) == 0 or below[0] == 0:
                continue
            low, high = line[below[0] - 1], line[below[0]]
            for _ in range(30):
                middle = (low + high) / 2
                low, high = (middle, high) if self.clearance(middle[None])[0] >= room else (low, middle)
            yield float(low[0]), float(low[1])

    def _points(self, count: int) -> FloatArray:
        return self.rng.uniform([0.0, 0.0], [self.width, self.depth], (count, 2))

    def _walls(self) -> list[Box]:
        w, d, rng = self.width, self.depth, self.rng
        middle = [(w / 2, 0.0, 0.0, w + WALL_M, WALL_M), (w / 2, d, 0.0, w + WALL_M, WALL_M)]
        middle += [(0.0, d / 2, 0.0, WALL_M, d), (w, d / 2, 0.0, WALL_M, d)]
        at, door = rng.uniform(0.35, 0.65) * w, 2.0 * self.body.radius + rng.uniform(0.12, 0.6) + self.cell
        begin = rng.uniform(0.3, d - door - 0.3)
        middle += [
            (at, begin / 2, 0.0, WALL_M, begin),
            (at, (begin + door + d) / 2, 0.0, WALL_M, d - begin - door),
        ]
        return [(*item, 2.0) for item in middle]

    def _things(self) -> list[Box]:
        return [self._thing() for _ in range(int(self.rng.integers(2, 6)))]

    def _thing(self) -> Box:
        rng = self.rng
        x, y = rng.uniform([0.6, 0.6], [self.width - 0.6, self.depth - 0.6])
        yaw = rng.choice([0.0, rng.uniform(0.0, math.pi)])
        length, width = rng.uniform(0.2, 1.1, 2)
        return x, y, yaw, length, width, rng.choice([0.12, 2.0])

    def _surprises(self) -> list[Box]:
        rng = self.rng
        found: list[Box] = []
        for x, y in self._points(int(rng.integers(1, 3))):
            yaw, (length, width) = rng.uniform(0.0, math.pi), rng.uniform(0.15, 0.5, 2)
            found.append((x, y, yaw, length, width, 2.0))
        return found


def write(room: Room, folder: Path, start: tuple[float, float]) -> dict[str, str]:
    """Return the files of a world; settings for the task."""
    grid = room.grid
    cv2.imwrite(str(folder / "map.png"), np.where(grid.occupied, 0, 254).astype(np.uint8)[::-1])
    (folder / "map.yaml").write_text(
        f"image: map.png\nresolution: {grid.resolution}\norigin: [{grid.origin_x}, {grid.origin_y}, 0.0]\n"
        "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"
    )
    away = [s for s in room.surprises if math.dist(s[:2], start) > room.body.radius + 0.8]
    heading = room.rng.uniform(-180.0, 180.0)
    (folder / "world.yaml").write_text(
        f"format: handcart-world/1\nstart: {{x_m: {start[0]}, y_m: {start[1]}, heading_deg: {heading}}}\n"
        + _listed("furniture", room.boxes)
        + _listed("surprises", away)
    )
    robot = room.body.robot
    if load_robot(robot).footprint_radius_m != room.body.radius:
        text = (SHIPPED_FOLDER / robot / "robot.yaml").read_text()
        (folder / "robot.urdf").write_text((SHIPPED_FOLDER / robot / f"{robot}.urdf").read_text())
        text = text.replace("footprint_radius_m: 0.34", f"footprint_radius_m: {room.body.radius}")
        (folder / "robot.yaml").write_text(text.replace(f"urdf: {robot}.urdf", "urdf: robot.urdf"))
        robot = str(folder / "robot.yaml")
    named = {key: str(folder / f"{key}.yaml") for key in ("map", "world", "places")}
    write_places(folder, {"home": (*start, heading)})
    return {**named, "robot": robot, "wait_s": "1.5"}


def write_places(
    folder: Path, places: dict[str, tuple[float, float, float]], tolerance_mm: float | None = None
) -> None:
    """Write places.yaml: x, y in [m] and the heading in [deg] of each place, with one tolerance for all."""
    allowed = "" if tolerance_mm is None else f", tolerance_mm: {tolerance_mm:g}"
    lines = [f"  {n}: {{x_m: {x}, y_m: {y}, heading_deg: {h}{allowed}}}\n" for n, (x, y, h) in places.items()]
    (folder / "places.yaml").write_text("format: handcart-places/1\nplaces:\n" + "".join(lines))


def _listed(key: str, boxes: list[Box]) -> str:
    lines = [
        f"  - {{name: {key[:-1]} {i}, x_m: {x}, y_m: {y}, heading_deg: {math.degrees(yaw)}, "
        f"size_m: [{length}, {width}, {height}]}}\n"
        for i, (x, y, yaw, length, width, height) in enumerate(boxes)
    ]
    return f"{key}:\n" + "".join(lines) if lines else ""
