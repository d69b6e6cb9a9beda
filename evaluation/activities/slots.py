"""Slots for things on the surfaces of a piece of furniture."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from typing import NamedTuple

from handcart.files.errors import Finding
from handcart.robotics.geometry.pose2 import Pose2

from .definition import Definition
from .furniture import FurnitureLevel, Piece
from .thing_relation import ThingRelation
from .thing_table import CarriedEntry
from .true_relations import NEAR_SHARE

MIN_GAP_M = 0.10  # between things, for the fingers and a thing that is set down 20 mm off
MIN_BOX_GAP_M = 0.05  # likewise in a box, where what is there has been put and seen
MIN_NEXT_GAP_M = 0.03  # likewise between things that have to be next to each other
NEXT_SHARE = 0.75  # of the greatest gap that counts as next to each other
EDGE_M = 0.06  # between a thing and the front edge
BOX_EDGE_M = 0.05  # likewise where that edge is a wall
MIN_BEFORE_M, MAX_BEFORE_M = 0.05, 0.12  # between a thing and what it is before


class ThingSlot(NamedTuple):
    """Pose for a thing on one surface of a piece of furniture."""

    level: FurnitureLevel
    pose: Pose2
    """Pose in the room; its heading is the heading of the thing."""


class FoundSlots(NamedTuple):
    """Poses computed for the things that an activity puts on a piece of furniture.

    It also has findings for the user if the things do not fit on its surfaces.
    """

    slots: dict[ThingRelation, ThingSlot]
    findings: list[Finding]


def slots_on(
    definition: Definition,
    piece: Piece,
    kind: str,
    here: Sequence[ThingRelation],
    sizes: Mapping[str, CarriedEntry],
) -> FoundSlots:
    """Return a slot, the pose on a surface, for each thing at a piece of furniture.

    The slots are in rows with equal gaps.

    Args:
        definition: the activity.
        piece: the furniture.
        kind: relation of the things to the piece, which selects its surfaces: `ontop` for the top, `inside`
            for the inside.
        here: relations of the things at the piece, either initially or finally.
        sizes: sizes of the things, by term.
    """
    slots: dict[ThingRelation, ThingSlot] = {}
    findings = list(_too_near(definition, piece, here, sizes))
    levels = [furniture_level for furniture_level in piece.levels() if furniture_level.relation == kind]
    rows = [_whole(levels)] if piece.entry.form == "box" and levels else levels
    for level, groups in zip(rows, _shared(_grouped(here), len(rows)), strict=True):
        gap = (level.size[0] - sum(_length(group, sizes) for group in groups)) / (len(groups) + 1)
        least = least_gap(piece)
        if gap < least:
            words = f"{piece.term} has no room for {len(here)} things; allowed: what fits with gaps of"
            findings.append(definition.finding([piece.term], f"{words} {least:g} m"))
        found = _in_row(piece, level, groups, sizes, gap)
        slots |= {item: ThingSlot(_nearest(piece, levels, slot), slot.pose) for item, slot in found}
    return FoundSlots(slots, findings)


def _whole(parts: Sequence[FurnitureLevel]) -> FurnitureLevel:
    """Return parts side by side as one level: nothing divides them."""
    first, width = parts[0], sum(part.size[0] for part in parts)
    middle = sum(part.x * part.size[0] for part in parts) / width
    return first._replace(x=middle, size=(width, first.size[1]))


def _nearest(piece: Piece, levels: Sequence[FurnitureLevel], slot: ThingSlot) -> FurnitureLevel:
    """Return the level that a slot is on."""
    along = slot.pose.relative_to(piece.pose).x
    return min(levels, key=lambda level: abs(level.x - along))


def least_gap(piece: Piece) -> float:
    """Return the smallest allowed gap between things on or in a piece of furniture, in [m]."""
    return MIN_BOX_GAP_M if piece.entry.form in ("box", "tray") else MIN_GAP_M


def next_gap(one: CarriedEntry, other_size: Sequence[float]) -> float:
    """Return a gap in [m] at which two things surely count as next to each other.

    It is 75 % of the largest such gap.

    Args:
        one: size of one thing.
        other_size: size of the other thing along x, y and z, in [m].
    """
    mean = (sum(one.size_mm) / 1e3 + sum(other_size)) / 3
    return NEXT_SHARE * NEAR_SHARE * mean


def before_gap(thing: CarriedEntry, size: Sequence[float]) -> float:
    """Return the gap to leave between a thing and the piece of furniture behind it, in [m].

    Args:
        thing: the thing, with its size.
        size: size of the piece of furniture along x, y and z, in [m].
    """
    return min(MAX_BEFORE_M, next_gap(thing, size))


def _too_near(
    definition: Definition,
    piece: Piece,
    here: Sequence[ThingRelation],
    sizes: Mapping[str, CarriedEntry],
) -> Iterator[Finding]:
    """Yield the things that count as next to each other only where the hand doesn't fit between them."""
    for relation in here:
        if relation.beside is None:
            continue
        if relation.beside == piece.term:
            gap, least = before_gap(sizes[relation.thing], piece.entry.size_m), MIN_BEFORE_M
        elif relation.beside in sizes:
            gap, least = _gap_between(relation, sizes), MIN_NEXT_GAP_M
        else:
            continue
        if gap < least:
            words = f"{relation.thing} is next to {relation.beside} only with gaps up to {1e3 * gap:.0f} mm"
            yield definition.finding([relation.thing], f"{words}; allowed: at least {1e3 * least:.0f} mm")


def _gap_between(each: ThingRelation, sizes: Mapping[str, CarriedEntry]) -> float:
    assert each.beside is not None
    return next_gap(sizes[each.thing], [side / 1e3 for side in sizes[each.beside].size_mm])


def _grouped(relations: Sequence[ThingRelation]) -> list[list[ThingRelation]]:
    """Return the relations in groups; things that have to be next to each other are in one group."""
    groups: list[list[ThingRelation]] = []
    things = {relation.thing for relation in relations}
    for relation in sorted(relations, key=lambda thing_relation: thing_relation.beside in things):
        own = next(
            (group for group in groups if any(other.thing == relation.beside for other in group)), None
        )
        if own is None:
            groups.append([relation])
        else:
            own.append(relation)
    return groups


def _shared(groups: Sequence[list[ThingRelation]], count: int) -> list[list[list[ThingRelation]]]:
    """Divide the groups, in their order, into `count` parts with about the same number of groups."""
    ends = [round(len(groups) * number / max(count, 1)) for number in range(count + 1)]
    return [list(groups[low:high]) for low, high in pairwise(ends)]


def _length(group: Sequence[ThingRelation], sizes: Mapping[str, CarriedEntry]) -> float:
    """Return the length of a group in a row, in [m]."""
    gaps = sum(_gap_between(relation, sizes) for relation in group[1:])
    return gaps + sum(sizes[relation.thing].size_mm[0] / 1e3 for relation in group)


def _in_row(
    piece: Piece,
    level: FurnitureLevel,
    groups: Sequence[Sequence[ThingRelation]],
    sizes: Mapping[str, CarriedEntry],
    gap: float,
) -> Iterator[tuple[ThingRelation, ThingSlot]]:
    """Yield slots along a level, with equal gaps between groups."""
    x = level.x - level.size[0] / 2
    for group in groups:
        x += gap
        for number, item in enumerate(group):
            entry = sizes[item.thing]
            width = entry.size_mm[0] / 1e3
            x += _gap_between(item, sizes) if number else 0.0
            y = level.y + _inward(piece, level, entry)
            yield item, ThingSlot(level, piece.in_room(x + width / 2, y))
            x += width


def _inward(piece: Piece, level: FurnitureLevel, thing: CarriedEntry) -> float:
    """Return y of a thing's middle relative to the level's middle, in [m]."""
    depth = thing.size_mm[1] / 1e3
    if level.relation == "front":
        return (level.size[1] - depth) / 2 - before_gap(thing, piece.entry.size_m)
    at_edge = (BOX_EDGE_M if piece.entry.form == "box" else EDGE_M) + depth / 2 - level.size[1] / 2
    return min(0.0, at_edge) if piece.entry.form in ("box", "tray", "floor") else at_edge
