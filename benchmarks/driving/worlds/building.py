"""Buildings of rooms with doors, loops and furniture, for `exploring`."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any, NamedTuple

import networkx as nx
import numpy as np
import yaml

Room = tuple[int, int]
DOORS_M = (0.95, 1.4)
"""Width of doors."""
ROOM_M = (3.2, 5.5)
"""Side of a room."""
EXTRA_DOORS = 0.5
"""Share of the walls between rooms that have a door although another way leads there: they close loops."""
MAX_FURNITURE_COUNT = 2
"""Maximum number of things in a room."""
CLEAR_M = 1.0
"""Room beside a thing: to walls, doors, other things and the robot's start."""


class Building(NamedTuple):
    """A world's file as data."""

    content: dict[str, Any]
    doors: int


def make_building(seed: int, rows: int, columns: int) -> Building:
    """Return a building of rows and columns of rooms, all of which can be reached."""
    rng = np.random.default_rng(seed)
    xs = np.concatenate([[0.0], np.cumsum(rng.uniform(*ROOM_M, columns))])
    ys = np.concatenate([[0.0], np.cumsum(rng.uniform(*ROOM_M, rows))])
    open_ = _doors(rng, rows, columns)
    walls = [_wall((0.0, y), (xs[-1], y)) for y in (ys[0], ys[-1])]
    walls += [_wall((x, 0.0), (x, ys[-1])) for x in (xs[0], xs[-1])]
    gaps = list[tuple[float, float]]()
    for column in range(columns):
        for row in range(rows):
            if column + 1 < columns:
                has_door = ((row, column), (row, column + 1)) in open_
                gap = _gap(rng, ys[row], ys[row + 1]) if has_door else None
                walls += _with_gap(xs[column + 1], (ys[row], ys[row + 1]), gap, True)
                gaps += [] if gap is None else [(xs[column + 1], sum(gap) / 2)]
            if row + 1 < rows:
                has_door = ((row, column), (row + 1, column)) in open_
                gap = _gap(rng, xs[column], xs[column + 1]) if has_door else None
                walls += _with_gap(ys[row + 1], (xs[column], xs[column + 1]), gap, False)
                gaps += [] if gap is None else [(sum(gap) / 2, ys[row + 1])]
    start = float(rng.uniform(1.0, xs[1] - 1.0)), float(rng.uniform(1.0, ys[1] - 1.0))
    boxes = [
        box
        for row in range(rows)
        for column in range(columns)
        for box in _things(rng, xs, ys, row, column, [*gaps, start])
    ]
    content = {
        "format": "handcart-world/1",
        "start": {"x_m": start[0], "y_m": start[1], "heading_deg": float(rng.uniform(-180.0, 180.0))},
        "walls": walls,
        "furniture": boxes,
    }
    return Building(content, len(gaps))


def write_building(building: Building, folder: Path) -> Path:
    """Write the world's file into a folder and return its path."""
    path = folder / "world.yaml"
    path.write_text(yaml.safe_dump(building.content), encoding="utf-8")
    return path


def _doors(rng: np.random.Generator, rows: int, columns: int) -> set[tuple[Room, Room]]:
    """Return the pairs of rooms with a door between: a random tree, and some more."""
    graph = nx.grid_2d_graph(rows, columns)
    for edge in graph.edges:
        graph.edges[edge]["weight"] = float(rng.uniform())
    tree = {tuple(sorted(edge)) for edge in nx.minimum_spanning_tree(graph).edges}
    others = [tuple(sorted(edge)) for edge in graph.edges if tuple(sorted(edge)) not in tree]
    more = rng.permutation(len(others))[: math.ceil(EXTRA_DOORS * len(others))]
    return tree | {others[number] for number in more}


def _gap(rng: np.random.Generator, low: float, high: float) -> tuple[float, float]:
    width = float(rng.uniform(*DOORS_M))
    begin = float(rng.uniform(low + 0.4, high - 0.4 - width))
    return begin, begin + width


def _wall(begin: tuple[float, float], end: tuple[float, float]) -> dict[str, list[float]]:
    return {"from_m": [round(float(v), 3) for v in begin], "to_m": [round(float(v), 3) for v in end]}


def _with_gap(
    fixed: float, ends: tuple[float, float], gap: tuple[float, float] | None, upright: bool
) -> list[dict[str, list[float]]]:
    parts = [ends] if gap is None else [(ends[0], gap[0]), (gap[1], ends[1])]
    return [_wall((fixed, a), (fixed, b)) if upright else _wall((a, fixed), (b, fixed)) for a, b in parts]


def _things(
    rng: np.random.Generator,
    xs: np.ndarray,
    ys: np.ndarray,
    row: int,
    column: int,
    keep: list[tuple[float, float]],
) -> list[dict[str, Any]]:
    """Return the furniture of a room, away from points that are kept clear."""
    found = list[dict[str, Any]]()
    clear = list(keep)
    for number in range(int(rng.integers(0, MAX_FURNITURE_COUNT + 1))):
        size = rng.uniform([0.3, 0.3], [1.0, 0.7])
        half = 0.5 * float(np.hypot(*size))
        low = np.array([xs[column], ys[row]]) + half + CLEAR_M
        high = np.array([xs[column + 1], ys[row + 1]]) - half - CLEAR_M
        if (low > high).any():
            continue
        at = rng.uniform(low, high)
        if min(math.dist(at, point) for point in clear) < half + CLEAR_M:
            continue
        clear.append((float(at[0]), float(at[1])))
        found.append(
            {
                "name": f"thing {row} {column} {number}",
                "x_m": float(at[0]),
                "y_m": float(at[1]),
                "heading_deg": float(rng.uniform(0.0, 180.0)),
                "size_m": [float(size[0]), float(size[1]), 1.0],
            }
        )
    return found
