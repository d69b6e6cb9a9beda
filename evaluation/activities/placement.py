"""Where the furniture of an activity is in its room."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from handcart.files.errors import FileError
from handcart.robotics.geometry.pose2 import Pose2

from .definition import Definition
from .furniture import SEGMENT_M, Piece
from .relations import ActivityRelations
from .slots import MIN_GAP_M, before_gap
from .thing_relation import entry_of, is_floor
from .thing_table import CarriedEntry, FurnitureEntry

DEPTH_M = 4.6  # of the room
AISLE_M = 1.0  # between two pieces of furniture, and beside them
WALL_GAP_M = 0.05  # between furniture and wall
FRONT_THINGS = 2  # in each part of the area before a piece, which is served from one place
ROUNDING_M = 0.01
FRONT_EDGE_M = 0.03  # between what is next to a piece and the edge of the area before it
STANDING_GAP_M = 0.08  # beside a piece of furniture on another one
PIECES_PER_WALL = 3
Extent = tuple[float, float, float, float]
"""Least x and y, greatest x and y, in [m]."""


class PlacedPieces(NamedTuple):
    """Pieces of furniture with their poses in a room, and the size of the room."""

    width: float
    """Width of the room along x, in [m]; its depth along y is `DEPTH_M`."""
    pieces: tuple[Piece, ...]
    floors: Mapping[str, Extent]
    """Parts of the floor, by term, if things are on two floors; otherwise empty."""


@dataclass(frozen=True)
class _Sizes:
    """Space that the pieces of an activity need."""

    definition: Definition
    relations: ActivityRelations
    things: Mapping[str, CarriedEntry]

    def entry(self, term: str) -> FurnitureEntry:
        """Return the size of a piece; a floor's area is as wide as its things need."""
        entry = entry_of(self.definition, term)
        assert isinstance(entry, FurnitureEntry)  # by its relations
        if entry.form != "floor":
            return entry
        here = [
            item.thing
            for item in (*self.relations.initial, *self.relations.moves)
            if item.furniture == term and item.beside not in self.relations.terms()
        ]
        _, depth, height = entry.size_m
        return entry.model_copy(update={"size_m": (max(entry.size_m[0], self.row(here)), depth, height)})

    def row(self, things: Sequence[str]) -> float:
        """Return the length of things in a row on the floor, in [m]."""
        if not things:
            return 0.0
        widest = max(self.things[thing].size_mm[0] for thing in things) / 1e3
        each_part = max(1, math.floor((SEGMENT_M - MIN_GAP_M) / (widest + MIN_GAP_M)))
        parts = math.ceil(len(things) / each_part)
        if parts > 1:
            return parts * SEGMENT_M
        return math.ceil(100.0 * (len(things) * (widest + MIN_GAP_M) + MIN_GAP_M)) / 100.0

    def front(self, term: str) -> tuple[float, float] | None:
        """Return width and depth of the area before a piece for what is next to it, in [m]; None for none."""
        here = [move.thing for move in self.relations.moves if move.beside == term]
        if not here:
            return None
        size = self.entry(term).size_m
        things = [self.things[item] for item in here]
        depth = max(thing.size_mm[1] / 1e3 + before_gap(thing, size) for thing in things)
        widest = max(self.things[item].size_mm[0] for item in here) / 1e3
        each_part = FRONT_THINGS * (widest + MIN_GAP_M) + MIN_GAP_M + ROUNDING_M
        return max(size[0], self.fronts(term) * each_part), depth + FRONT_EDGE_M

    def fronts(self, term: str) -> int:
        """Return the number of parts of the area before a piece."""
        count = sum(move.beside == term for move in self.relations.moves)
        return max(1, math.ceil(count / FRONT_THINGS))

    def width(self, term: str) -> float:
        """Return the width that a piece takes along its wall, in [m]."""
        front = self.front(term)
        return max(self.entry(term).size_m[0], 0.0 if front is None else front[0])

    def standing(self, term: str) -> list[str]:
        """Return the terms of what is on a piece."""
        relations = self.relations
        return [text for text in relations.terms() if relations.supports.get(text) == term]

    def reserved(self, term: str) -> float:
        """Return the width of a table that what is on it takes, in [m]."""
        on_it = [] if is_floor(term) else self.standing(term)
        widths = sum(self.entry(item).size_m[0] + STANDING_GAP_M for item in on_it)
        return widths + STANDING_GAP_M if on_it else 0.0

    def floor(self, term: str) -> str | None:
        """Return the floor that a piece belongs to; None if none is stated."""
        if is_floor(term):
            return term
        moved = [move.furniture for move in self.relations.moves if move.beside == term]
        below = self.relations.supports.get(term)
        return moved[0] if moved else (below if below is not None and is_floor(below) else None)


def place_pieces(
    definition: Definition,
    relations: ActivityRelations,
    names: Mapping[str, str],
    things: Mapping[str, CarriedEntry],
) -> PlacedPieces:
    """Arrange the furniture of an activity along the north and the south wall of a room.

    Args:
        definition: the activity.
        relations: where things are, and where they go.
        names: names of the furniture, by its term in BDDL.
        things: entries with the sizes of the carried things, by term.

    Raises:
        FileError: things are on more than two floors, or a table is too narrow for the things on it.
    """
    sizes = _Sizes(definition, relations, things)
    terms = [text for text in relations.terms() if not relations.stands_on_furniture(text)]
    used = [text for text in relations.terms() if is_floor(text)]
    used += [sizes.floor(text) or "" for text in terms if sizes.front(text) is not None]
    floors = list(dict.fromkeys(text for text in used if text))
    if len(floors) > 2:
        words = f"things are on {len(floors)} floors; allowed: two"
        raise FileError([definition.finding([floors[2]], words)])
    walls = _walls(sizes, terms, floors)
    lengths = [sum(sizes.width(item) + AISLE_M for item in wall) + AISLE_M for wall in walls]
    pieces: list[Piece] = []
    for wall, north in zip(walls, (True, False), strict=True):
        x = (max(lengths) - sum(sizes.width(item) + AISLE_M for item in wall) - AISLE_M) / 2 + AISLE_M
        for term in wall:
            pieces += _piece(sizes, names, term, x + sizes.width(term) / 2, north)
            x += sizes.width(term) + AISLE_M
    width = max(max(lengths), DEPTH_M)
    halves = ((0.0, DEPTH_M / 2, width, DEPTH_M), (0.0, 0.0, width, DEPTH_M / 2))
    parts = dict(zip(floors, halves, strict=False)) if len(floors) == 2 else {}
    return PlacedPieces(width, tuple(pieces), parts)


def _walls(sizes: _Sizes, terms: Sequence[str], floors: Sequence[str]) -> tuple[list[str], list[str]]:
    """Return the terms of the furniture along each wall; with two floors, the pieces of a floor share a
    wall.
    """
    if len(floors) < 2:
        return (list(terms[0::2]), list(terms[1::2])) if len(terms) > PIECES_PER_WALL else (list(terms), [])
    walls: tuple[list[str], list[str]] = ([], [])
    others = []
    for term in terms:
        floor = sizes.floor(term)
        if floor in floors:
            walls[floors.index(floor)].append(term)
        else:
            others.append(term)
    for term in others:
        min(walls, key=len).append(term)
    return walls


def _piece(sizes: _Sizes, names: Mapping[str, str], term: str, x: float, north: bool) -> Iterator[Piece]:
    """Yield a piece in the middle of its place along a wall, and what is on it."""
    entry, reserved = sizes.entry(term), sizes.reserved(term)
    if reserved > entry.size_m[0]:
        words = f"{term} is too narrow for what is on it; allowed: at most {entry.size_m[0]:g} m"
        raise FileError([sizes.definition.finding([term], words)])
    away = WALL_GAP_M + entry.size_m[1] / 2
    pose = Pose2(x, DEPTH_M - away, 0.0) if north else Pose2(x, away, math.pi)
    piece = Piece(
        names[term], term, entry, pose, reserved=reserved, front=sizes.front(term), fronts=sizes.fronts(term)
    )
    yield piece
    right = entry.size_m[0] / 2 - STANDING_GAP_M
    for item in [] if is_floor(term) else sizes.standing(term):
        upper = sizes.entry(item)
        middle = piece.in_room(right - upper.size_m[0] / 2, (upper.size_m[1] - entry.size_m[1]) / 2)
        yield Piece(names[item], item, upper, middle, base=entry.size_m[2])
        right -= upper.size_m[0] + STANDING_GAP_M
