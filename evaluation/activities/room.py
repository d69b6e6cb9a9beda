"""The room of an activity: where its furniture is, and where each thing is and goes."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

from handcart.files.errors import FileError, Finding
from handcart.robotics.geometry.pose2 import Pose2

from .definition import Definition
from .furniture import FurnitureLevel, Piece
from .relations import ActivityRelations, ThingRelation, entry_of
from .thing_table import CarriedEntry, FurnitureEntry

DEPTH_M = 4.6  # of the room
AISLE_M = 1.0  # between two pieces of furniture, and beside them
WALL_GAP_M = 0.05  # between furniture and wall
MIN_GAP_M = 0.12  # between things, for the fingers
MIN_BOX_GAP_M = 0.05  # likewise in a box, where what is there has been put and seen
EDGE_M = 0.06  # between a thing and the front edge
PIECES_PER_WALL = 3


class ThingSlot(NamedTuple):
    """A place for a thing on a level of a piece."""

    level: FurnitureLevel
    pose: Pose2
    """In the room; the heading is that of the thing."""


@dataclass(frozen=True)
class Room:
    """Furniture along two walls, with a slot for each thing at first and at the end."""

    width: float
    """Along x, in [m]; along y it is `DEPTH_M`."""
    pieces: tuple[Piece, ...]
    names: Mapping[str, str]
    """Names of things and furniture in our files, by term."""
    sizes: Mapping[str, CarriedEntry]
    """Sizes of carried things, by term."""
    at_first: Mapping[str, ThingSlot]
    at_end: Mapping[str, ThingSlot]
    """Of the things that have to be moved."""

    @property
    def home(self) -> Pose2:
        """Place of the base at first."""
        return Pose2(self.width / 2, DEPTH_M / 2, 0.0)


def furnish(definition: Definition, relations: ActivityRelations, sizes: Mapping[str, CarriedEntry]) -> Room:
    """Return the room of an activity.

    Args:
        definition: the activity.
        relations: where things are, and where they go.
        sizes: sizes of the carried things, by term; some may have been scaled.

    Raises:
        FileError: a piece of furniture has too little room for what belongs there.
    """
    names = names_of(definition, [*relations.terms(), *sizes])
    width, pieces = _placed(definition, relations.terms(), names)
    slots: dict[ThingRelation, ThingSlot] = {}
    findings: list[Finding] = []
    wanted = [*relations.initial, *relations.moves]
    for piece in pieces:
        for kind in ("ontop", "inside"):
            here = [each for each in wanted if (each.furniture, each.kind) == (piece.term, kind)]
            levels = [each for each in piece.levels() if each.relation == kind]
            for level, row in zip(levels, _shared(here, len(levels)), strict=True):
                widths = [sizes[each.thing].size_mm[0] / 1e3 for each in row]
                gap = (level.size[0] - sum(widths)) / (len(row) + 1)
                least = MIN_BOX_GAP_M if piece.entry.form == "box" else MIN_GAP_M
                if gap < least:
                    words = (
                        f"{piece.term} has no room for {len(here)} things; allowed: what fits with gaps of"
                    )
                    findings.append(definition.finding([piece.term], f"{words} {least:g} m"))
                slots |= dict(zip(row, _in_row(piece, level, row, sizes, gap), strict=True))
    if findings:
        raise FileError(findings)
    first = {each.thing: slots[each] for each in relations.initial}
    return Room(width, pieces, names, sizes, first, {each.thing: slots[each] for each in relations.moves})


def names_of(definition: Definition, terms: Sequence[str]) -> dict[str, str]:
    """Return short names of terms: `book_1` for `book.n.02_1`, or longer ones where two would be equal."""
    short = {each: _short(each) for each in terms}
    twice = {name for name in short.values() if list(short.values()).count(name) > 1}
    return {term: term.replace(".", "_") if name in twice else name for term, name in short.items()}


def _short(term: str) -> str:
    category, _, number = term.rpartition("_")
    return f"{category.split('.')[0].replace('__', '_').replace('-', '_')}_{number}"


def _placed(
    definition: Definition, terms: Sequence[str], names: Mapping[str, str]
) -> tuple[float, tuple[Piece, ...]]:
    """Return the width of the room, and the furniture along its walls: north first, then south."""
    walls = [terms[0::2], terms[1::2]] if len(terms) > PIECES_PER_WALL else [terms, []]
    widths = {each: _size(definition, each)[0] for each in terms}
    lengths = [sum(widths[each] + AISLE_M for each in wall) + AISLE_M for wall in walls]
    pieces = []
    for wall, north in zip(walls, (True, False), strict=True):
        x = (max(lengths) - sum(widths[each] + AISLE_M for each in wall) - AISLE_M) / 2 + AISLE_M
        for term in wall:
            away = WALL_GAP_M + _size(definition, term)[1] / 2
            middle = x + widths[term] / 2
            pose = Pose2(middle, DEPTH_M - away, 0.0) if north else Pose2(middle, away, math.pi)
            entry = entry_of(definition, term)
            assert isinstance(entry, FurnitureEntry)  # by their relations
            pieces.append(Piece(names[term], term, entry, pose))
            x += widths[term] + AISLE_M
    return max(max(lengths), DEPTH_M), tuple(pieces)


def _size(definition: Definition, term: str) -> tuple[float, float, float]:
    entry = entry_of(definition, term)
    assert isinstance(entry, FurnitureEntry)
    return entry.size_m


def _shared(relations: Sequence[ThingRelation], count: int) -> list[list[ThingRelation]]:
    """Return the relations in parts of about the same length, in their order."""
    ends = [round(len(relations) * number / max(count, 1)) for number in range(count + 1)]
    return [list(relations[low:high]) for low, high in pairwise(ends)]


def _in_row(
    piece: Piece,
    level: FurnitureLevel,
    row: Sequence[ThingRelation],
    sizes: Mapping[str, CarriedEntry],
    gap: float,
) -> Iterator[ThingSlot]:
    """Yield slots along the front edge of a level, with equal gaps."""
    x = level.x - level.size[0] / 2
    for each in row:
        width, depth = (side / 1e3 for side in sizes[each.thing].size_mm[:2])
        in_box = piece.entry.form == "box"
        y = level.y if in_box else level.y - level.size[1] / 2 + EDGE_M + depth / 2
        yield ThingSlot(level, piece.in_room(x + gap + width / 2, y))
        x += gap + width
