"""The room of an activity: where its furniture is, and where each thing is and goes."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

from handcart.files.errors import FileError, Finding
from handcart.robotics.geometry.pose2 import Pose2

from .definition import Definition
from .furniture import Piece
from .placement import DEPTH_M, Extent, place_pieces
from .relations import ActivityRelations
from .slots import ThingSlot, slots_on
from .thing_relation import ThingRelation
from .thing_table import CarriedEntry

SIDE_TABLE = "side_table"
"""Name of the table on which a thing is put down to be gripped in another way."""
SIDE_TABLE_POSE = Pose2(0.35, DEPTH_M / 2, math.pi)
SIDE_TABLE_SIZE_M = (0.4, 0.5, 0.55)
ROUND_WALLS = 3  # of a surface or more: its things are put down from above


@dataclass(frozen=True)
class Room:
    """Room of an activity with furniture along two walls, and the first and last pose of each thing."""

    width: float
    """Width of the room along x, in [m]; its depth along y is `DEPTH_M`."""
    pieces: tuple[Piece, ...]
    names: Mapping[str, str]
    """Names of things and furniture in our files, by term."""
    sizes: Mapping[str, CarriedEntry]
    """Sizes of carried things, by term."""
    at_first: Mapping[str, ThingSlot]
    at_end: Mapping[str, ThingSlot]
    """Final slots of the things that have to be moved, by term."""
    beside: Mapping[str, str]
    """Term of the thing or furniture that a moved thing has to be next to, by term of the moved thing."""
    floors: Mapping[str, Extent]
    """Parts of the floor, by term, if things are on two floors: a line divides the room."""

    @property
    def home(self) -> Pose2:
        """Start pose of the base on the room's map."""
        return Pose2(self.width / 2, DEPTH_M / 2, 0.0)

    def is_regripped(self, term: str) -> bool:
        """Return whether a moved thing may have to be gripped in another way on its way.

        Under a board the hand grips from the side; into a box the thing is put down from above.
        """
        source, target = self.at_first[term].level, self.at_end[term].level
        return source.clearance is not None and len(target.walls) >= ROUND_WALLS

    @property
    def has_side_table(self) -> bool:
        """True if a thing may have to be gripped in another way."""
        return any(self.is_regripped(term) for term in self.at_end)


def furnish(definition: Definition, relations: ActivityRelations, sizes: Mapping[str, CarriedEntry]) -> Room:
    """Return the room of a BEHAVIOR-1K activity, with its furniture and the first and last poses of things.

    Args:
        definition: the activity.
        relations: where things are, and where they go.
        sizes: sizes of the carried things, by their terms in the activity; some may have been scaled.

    Raises:
        FileError: a piece of furniture has too little room for the things on, in or next to it.
    """
    names = names_of(definition, [*relations.terms(), *sizes])
    placed = place_pieces(definition, relations, names, sizes)
    slots: dict[ThingRelation, ThingSlot] = {}
    findings: list[Finding] = []
    wanted = [*relations.initial, *relations.moves]
    for piece in placed.pieces:
        for kind in ("ontop", "inside", "front"):
            here = [item for item in wanted if _is_at(item, piece, kind, sizes)]
            found = slots_on(definition, piece, kind, here, sizes)
            slots |= found.slots
            findings += found.findings
    if findings:
        raise FileError(findings)
    first = {item.thing: slots[item] for item in relations.initial}
    end = {move.thing: slots[move] for move in relations.moves}
    beside = {move.thing: move.beside for move in relations.moves if move.beside is not None}
    return Room(placed.width, placed.pieces, names, sizes, first, end, beside, placed.floors)


def _is_at(relation: ThingRelation, piece: Piece, kind: str, things: Collection[str]) -> bool:
    """Return whether a thing is at a piece of furniture, in a kind of relation to it."""
    if kind == "front":
        return relation.beside == piece.term
    is_before_another = relation.beside is not None and relation.beside not in things
    return (relation.furniture, relation.kind) == (piece.term, kind) and not is_before_another


def names_of(definition: Definition, terms: Sequence[str]) -> dict[str, str]:
    """Return short names of terms: `book_1` for `book.n.02_1`; longer names where short names would be
    equal.
    """
    short = {text: _short(text) for text in terms}
    twice = {name for name in short.values() if list(short.values()).count(name) > 1}
    return {term: term.replace(".", "_") if name in twice else name for term, name in short.items()}


def _short(term: str) -> str:
    category, _, number = term.rpartition("_")
    return f"{category.split('.')[0].replace('__', '_').replace('-', '_')}_{number}"
