"""Office floors to measure on: rooms with doors on both sides of corridors, furniture in them."""

from __future__ import annotations

import numpy as np

from handcart.robotics.navigation.maps.grid_map import GridMap, from_boxes

WALL_M = 0.1
Boxes = list[tuple[float, float, float, float, float]]


def wall_boxes(size: tuple[float, float]) -> Boxes:
    """Return the four outer walls of a floor whose lower-left corner is (0, 0)."""
    w, h = size
    return [
        (w / 2, WALL_M / 2, 0.0, w, WALL_M),
        (w / 2, h - WALL_M / 2, 0.0, w, WALL_M),
        (WALL_M / 2, h / 2, 0.0, WALL_M, h),
        (w - WALL_M / 2, h / 2, 0.0, WALL_M, h),
    ]


def _row_wall(rng: np.random.Generator, y: float, width: float, room: float) -> Boxes:
    """Return a wall along x with a door of 1 m for each room."""
    boxes: Boxes = []
    left = 0.0
    for k in range(round(width / room)):
        door = (k + rng.uniform(0.25, 0.75)) * room
        boxes.append(((left + door - 0.5) / 2, y, 0.0, door - 0.5 - left, WALL_M))
        left = door + 0.5
    return [*boxes, ((left + width) / 2, y, 0.0, width - left, WALL_M)]


def office_boxes(seed: int, size: tuple[float, float]) -> Boxes:
    """Boxes (x, y, yaw, length, width) of an office of this size, in [m]."""
    rng = np.random.default_rng(seed)
    boxes = wall_boxes(size)
    room, deep, corridor = 5.0, 5.5, 2.5
    y = 0.0
    while y + 2 * deep + corridor <= size[1] + 1.6:
        for wall in (y + deep, y + deep + corridor):
            boxes += _row_wall(rng, wall, size[0], room)
        for low, high in ((y, y + deep), (y + deep + corridor, min(y + 2 * deep + corridor, size[1]))):
            boxes += [
                (k * room, (low + high) / 2, 0.0, WALL_M, high - low) for k in range(1, round(size[0] / room))
            ]
            boxes += _furniture(rng, size[0], room, low, high)
        y += 2 * deep + corridor
        if y + deep < size[1]:
            boxes.append((size[0] / 2, y, 0.0, size[0] - 4.0, WALL_M))
    return boxes


def _furniture(rng: np.random.Generator, width: float, room: float, low: float, high: float) -> Boxes:
    boxes: Boxes = []
    for k in range(round(width / room)):
        for _ in range(2):
            x, y = rng.uniform(k * room + 1.2, (k + 1) * room - 1.2), rng.uniform(low + 1.2, high - 1.2)
            boxes.append((x, y, rng.uniform(0, np.pi), rng.uniform(0.4, 1.4), rng.uniform(0.3, 0.7)))
    return boxes


def office_map(seed: int, width: int, height: int, resolution: float = 0.05) -> GridMap:
    """Return an office floor of `width` x `height` cells."""
    size = (width * resolution, height * resolution)
    return from_boxes(office_boxes(seed, size), resolution, (0.0, 0.0), size)
