"""Generator of libraries: a room with shelves, books with gaps, a book to return."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Literal, get_args

import numpy as np

from handcart.files.errors import InputError
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.maps.grid_map import FloorBox, GridMap, from_boxes
from handcart.robotics.navigation.routes.route import plan_route
from handcart.robotics.navigation.routes.voronoi_graph import voronoi_graph
from handcart.robotics.numerics.arrays import FloatArray

from .library_books import GeneratedBook, ShelfRow, make_row
from .library_room import (
    DEPTH,
    HOME_POSE,
    OUTER_WIDTH_M,
    ROOM_FURNITURE,
    SHELF_DEPTH,
    SHELF_POSES,
    STAND_OFF,
    WIDTH,
)
from .unfriendly import UNFRIENDLY_FACTORS, make_unfriendly, no_slot

Tag = Literal["readable", "smeared", "unknown"]
Blocked = Literal["none", "way_around", "closed"]

MAP_RESOLUTION_M = 0.02  # [m], as drawn from a floor plan
FREE_RADIUS_M = 0.38  # [m] of free space around a route
BOX_SIZE_M = (0.5, 0.4, 0.6)  # [m]
DOORWAY_M = (0.7, 1.9, 2.5)  # [m]: a doorway from x to x at y, the only way out of the corner of `closed`


class NoSuchLibrary(InputError):
    """Error for a library that cannot be generated with the requested properties."""


@dataclass(frozen=True)
class UnmappedBox:
    """Box on the floor of a generated library that the robot's map does not show."""

    pose: Pose2
    size: tuple[float, float, float]


@dataclass(frozen=True)
class Library:
    """Generated library, with walls, shelves, books and obstacles of its simulated world, and the map that
    the robot has of it.
    """

    seed: int
    walls: tuple[tuple[float, float, float, float], ...]
    """Ends of each wall, x, y to x, y, in [m]."""
    rows: tuple[ShelfRow, ...]
    wanted: tuple[GeneratedBook, ...]
    """The books to return: the first is on the robot's tray, the others a person hands over."""
    tag: Tag
    surprises: tuple[UnmappedBox, ...]
    map: GridMap
    no_slot: Mapping[int, str]
    """Reason why a lent book has no slot, by its accession number."""


def make_library(
    seed: int,
    misplaced: bool = True,
    gap: bool = True,
    tag: Tag = "readable",
    blocked: Blocked = "none",
    books: int = 1,
    unfriendly: tuple[str, ...] = (),
    level: float = 1.0,
) -> Library:
    """Return a random simulated library of five shelves with books.

    Args:
        seed: seed of all random choices.
        misplaced: True to put one misplaced book directly beside a gap on each shelf.
        gap: True to leave the gap of the book to return; otherwise its row is closed.
        tag: tag of the book to return.
        books: number of books to return, each to another shelf.
        blocked: box on the way to the shelf: with another route, or in the only doorway.
        unfriendly: factors that make the shelves difficult, names in `UNFRIENDLY_FACTORS` or `all`.
        level: difficulty of these factors, from 0 (none) to 1.
    """
    factors = _factors(unfriendly)
    for value, kind in ((tag, Tag), (blocked, Blocked)):
        if value not in get_args(kind):
            raise NoSuchLibrary(f"no library with {value!r}; allowed: {', '.join(get_args(kind))}")
    rng = np.random.default_rng(seed)
    rows = tuple(
        make_row(rng, f"shelf_{i + 1}", 1 + 45 * i, 100 * (1 + 2 * i), misplaced)
        for i in range(len(SHELF_POSES))
    )
    if not 1 <= books <= len(rows):
        raise NoSuchLibrary(f"no library with {books} books to return; allowed: 1 to {len(rows)}")
    shelves = [int(item) for item in rng.permutation(len(rows))[:books]]
    wanted = tuple(rows[shelf].lent[int(rng.integers(0, 2))] for shelf in shelves)
    rows, wanted, spoilt = _unfriendly(rows, wanted, factors, level, seed)
    chosen = shelves[0]
    if not gap:
        rows = (*rows[:chosen], _closed(rows[chosen], wanted[0]), *rows[chosen + 1 :])
    walls = _walls(blocked == "closed")
    grid = _map(walls)
    surprises = _surprises(rng, blocked, grid, place_before(SHELF_POSES[chosen]))
    return Library(seed, walls, rows, wanted, tag, surprises, grid, spoilt)


def _factors(named: tuple[str, ...]) -> tuple[str, ...]:
    for name in named:
        if name not in UNFRIENDLY_FACTORS and name != "all":
            raise NoSuchLibrary(
                f"no library that is unfriendly by {name!r}; allowed: all, {', '.join(UNFRIENDLY_FACTORS)}"
            )
    return tuple(UNFRIENDLY_FACTORS) if "all" in named else named


def _unfriendly(
    rows: tuple[ShelfRow, ...],
    wanted: tuple[GeneratedBook, ...],
    factors: tuple[str, ...],
    level: float,
    seed: int,
) -> tuple[tuple[ShelfRow, ...], tuple[GeneratedBook, ...], dict[int, str]]:
    """Return harder rows, the wanted books in them, and reasons for missing slots by the lent book."""
    if not factors or level <= 0.0:
        return rows, wanted, {}
    numbers = [book.accession for book in wanted]
    harder = [
        make_unfriendly(row, numbers, factors, level, np.random.default_rng([seed, at]))
        for at, row in enumerate(rows)
    ]
    lent = {book.accession: book for row, _ in harder for book in row.lent}
    spoilt = {number: why for _, whys in harder for number, why in whys.items()}
    for row, _ in harder:
        spoilt |= {book.accession: why for book in row.lent if (why := no_slot(row, book, spoilt))}
    return tuple(row for row, _ in harder), tuple(lent[number] for number in numbers), spoilt


def place_before(shelf: Pose2) -> Pose2:
    """Return the pose map_T_base at which a robot stops to work at a shelf.

    Args:
        shelf: pose map_T_shelf, with x into the shelf.
    """
    return shelf.compose(Pose2(-STAND_OFF, 0.0, 0.0))


def _closed(row: ShelfRow, wanted: GeneratedBook) -> ShelfRow:
    """Return the row without the gap of a lent book: its number is missing, and its neighbours touch."""
    gaps = [i for i, item in enumerate(row.standing) if isinstance(item, float)]
    at = gaps[row.lent.index(wanted)]
    return replace(row, standing=row.standing[:at] + row.standing[at + 1 :])


def _walls(corner: bool) -> tuple[tuple[float, float, float, float], ...]:
    room = (
        (0.0, 0.0, WIDTH, 0.0),
        (WIDTH, 0.0, WIDTH, DEPTH),
        (WIDTH, DEPTH, 0.0, DEPTH),
        (0.0, DEPTH, 0.0, 0.0),
    )
    left, right, y = DOORWAY_M
    if not corner:
        return room
    return (*room, (0.0, y, left, y), (right, y, 2.6, y), (2.6, y, 2.6, 0.0))


def _map(walls: tuple[tuple[float, float, float, float], ...]) -> GridMap:
    """Return the floor plan: walls, furniture, the plinths of the shelves."""
    boxes = [
        FloorBox(
            (x0 + x1) / 2,
            (y0 + y1) / 2,
            math.atan2(y1 - y0, x1 - x0),
            math.hypot(x1 - x0, y1 - y0) + 0.1,
            0.1,
        )
        for x0, y0, x1, y1 in walls
    ]
    boxes += [FloorBox(item.x, item.y, 0.0, item.length, item.width) for item in ROOM_FURNITURE]
    for shelf in SHELF_POSES:
        middle = shelf.compose(Pose2(SHELF_DEPTH / 2, 0.0, 0.0))
        boxes.append(FloorBox(middle.x, middle.y, shelf.theta, SHELF_DEPTH, OUTER_WIDTH_M))
    return from_boxes(boxes, MAP_RESOLUTION_M, (-0.2, -0.2), (WIDTH + 0.4, DEPTH + 0.4))


def _surprises(
    rng: np.random.Generator, blocked: Blocked, grid: GridMap, goal: Pose2
) -> tuple[UnmappedBox, ...]:
    if blocked == "none":
        return ()
    if blocked == "closed":
        left, right, y = DOORWAY_M
        return (UnmappedBox(Pose2((left + right) / 2, y, 0.0), BOX_SIZE_M),)
    route = _route(grid, goal)
    if route is None:
        raise NoSuchLibrary("no way leads from home to the shelf")
    for share in rng.permutation(np.linspace(0.2, 0.85, 40)):
        x, y = route[int(share * len(route))]
        box = UnmappedBox(Pose2(float(x), float(y), float(rng.uniform(0.0, math.pi))), BOX_SIZE_M)
        if _route(grid.with_points(_outline(box), 0.12), goal) is not None and _apart(box, goal):
            return (box,)
    raise NoSuchLibrary("no box on the way leaves another way")


def _apart(box: UnmappedBox, goal: Pose2) -> bool:
    return box.pose.distance(goal) > 0.9 and box.pose.distance(HOME_POSE) > 0.9


def _route(grid: GridMap, goal: Pose2) -> FloatArray | None:
    route = plan_route(voronoi_graph(grid, FREE_RADIUS_M, (HOME_POSE.x, HOME_POSE.y)), HOME_POSE, goal, 0.15)
    return None if route is None else route.points


def _outline(box: UnmappedBox) -> FloatArray:
    along = np.linspace(-0.5, 0.5, 40)
    length, width, _ = box.size
    sides = [np.column_stack([along * length, np.full(40, side * width / 2)]) for side in (-1, 1)]
    ends = [np.column_stack([np.full(40, end * length / 2), along * width]) for end in (-1, 1)]
    return box.pose.apply(np.vstack(sides + ends))
