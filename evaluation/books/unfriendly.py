"""Factors that make a library hard: covers, light, labels, gloss, leaning rows, things in between."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, TypeGuard

import numpy as np

from .library_books import LABEL_FONTS, GeneratedBook, ShelfRow
from .library_room import CLEAR_WIDTH_M

OTHER_FONTS = ("STIXGeneral", "STIXGeneralBol", "cmr10", "cmss10", "cmtt10", "cmb10")
LEAST_PLAY_MM = 3.0  # that a slot must be wider than its book to count as one
IN_THE_WAY = 0.3  # of the wanted slots that something is in or leans into, at level 1
_THICKEST_HELD, _THINNEST_TAGGED = 55.0, 15.0
_LEAST_SLOT_MM = 10.0  # narrower gaps in a row are play between books


@dataclass(frozen=True)
class _Making:
    """Row that is being made harder."""

    row: ShelfRow
    wanted: frozenset[int]
    """Accessions of the books whose slots mostly stay free."""
    level: float
    rng: np.random.Generator
    spoilt: dict[int, str] = field(default_factory=dict)
    """Reason why a book has no slot, by its accession."""

    def each(self, change: Callable[[GeneratedBook], GeneratedBook]) -> _Making:
        """Change every book, including the lent ones."""
        made = {book.accession: change(book) for book in (*_books(self.row), *self.row.lent)}
        standing = tuple(x if isinstance(x, float) else made[x.accession] for x in self.row.standing)
        lent = tuple(made[book.accession] for book in self.row.lent)
        return replace(self, row=replace(self.row, standing=standing, lent=lent))


def make_unfriendly(
    row: ShelfRow, wanted: Collection[int], factors: Collection[str], level: float, rng: np.random.Generator
) -> tuple[ShelfRow, dict[int, str]]:
    """Return a row of books that is made more difficult for a robot, and the reason for each lent book that
    now has no slot, by its accession number.

    Args:
        row: the row before the change.
        wanted: accession numbers of the lent books that are to be returned.
        factors: names in `UNFRIENDLY_FACTORS`.
        level: difficulty, from 0 (none) to 1.
        rng: random generator.
    """
    making = _Making(row, frozenset(wanted), level, rng)
    for name, factor in UNFRIENDLY_FACTORS.items():
        if name in factors:
            making = factor(making)
    return making.row, making.spoilt


def _covers(m: _Making) -> _Making:
    """Spread the greys of covers from nearly black to nearly white (usually 70 to 180)."""
    low, high = 70.0 * (1.0 - m.level), 180.0 + 75.0 * m.level
    return m.each(lambda book: replace(book, grey=round(m.rng.uniform(low, high))))


def _light(m: _Making) -> _Making:
    """Light each shelf by lamps of its own."""
    return replace(m, row=replace(m.row, light=0.1 + 0.9 * m.level))


def _thickness(m: _Making) -> _Making:
    """Spread the thickness of books from 6 to 80 mm (usually 15 to 45); the hand can still grip the books to
    return.
    """
    low, high = 15.0 - 9.0 * m.level, 45.0 + 35.0 * m.level
    gaps = dict(zip((b.accession for b in m.row.lent), _gaps(m.row), strict=True))
    plays = {book.accession: gaps[book.accession] - book.thickness_mm for book in m.row.lent}
    lent = {book.accession for book in m.row.lent}

    def change(book: GeneratedBook) -> GeneratedBook:
        ends = (_THINNEST_TAGGED, _THICKEST_HELD) if book.accession in lent else (low, high)
        thickness = round(m.rng.uniform(max(low, ends[0]), min(high, ends[1])), 1)
        return replace(book, thickness_mm=thickness, label_mm=min(book.label_mm, thickness))

    changed = m.each(change)
    return _fitted(_with_plays(changed, plays))


def _labels(m: _Making) -> _Making:
    """Spread the width of labels across the spine from 6 to 25 mm; wide ones have two lines."""

    def change(book: GeneratedBook) -> GeneratedBook:
        width = m.rng.uniform(10.0 - 4.0 * m.level, 10.0 + 15.0 * m.level)
        width = round(min(width, book.thickness_mm), 1)
        return replace(book, label_mm=width, label_lines=2 if width > 12.0 else 1)

    return m.each(change)


def _fonts(m: _Making) -> _Making:
    """Print all labels, or a share of them, in other typefaces."""

    def change(book: GeneratedBook) -> GeneratedBook:
        faces = OTHER_FONTS if m.rng.random() < m.level else LABEL_FONTS
        return replace(book, font=str(m.rng.choice(faces)))

    return m.each(change)


def _glare(m: _Making) -> _Making:
    """Make spines glossy, so that they mirror a window."""
    return m.each(lambda book: replace(book, gloss=round(m.level * m.rng.uniform(0.0, 1.0), 2)))


def _narrow(m: _Making) -> _Making:
    """Make slots slightly narrower, some of them too narrow."""
    plays = {book.accession: round(m.rng.uniform(4.0 - 6.0 * m.level, 9.0), 1) for book in m.row.lent}
    return _with_plays(m, plays)


def _leaning(m: _Making) -> _Making:
    """Let up to three books in a row lean into slots."""
    standing = list(m.row.standing)
    for book in m.row.lent:
        share = m.level * (IN_THE_WAY if book.accession in m.wanted else 1.0)
        if m.rng.random() < share:
            m.spoilt[book.accession] = "a neighbour leans into it"
            _lean(standing, m.row.lent.index(book), int(m.rng.integers(1, 4)))
    return _fitted(replace(m, row=replace(m.row, standing=tuple(standing))))


def _objects(m: _Making) -> _Making:
    """Put objects that are not books into slots, as far forward as books or deeper."""
    objects = list(m.row.objects)
    for number, book in enumerate(m.row.lent):
        share = m.level * (IN_THE_WAY if book.accession in m.wanted else 1.0)
        if m.rng.random() < share:
            m.spoilt[book.accession] = "something stands in it"
            left, gap = _gap_ends(m.row, number)
            width = gap * m.rng.uniform(0.5, 0.98)
            objects.append(
                {
                    "at_mm": round(left + m.rng.uniform(0.0, gap - width), 1),
                    "width_mm": round(width, 1),
                    "height_mm": round(m.rng.uniform(40.0, 200.0)),
                    "front_mm": round(m.rng.choice([0.0, m.rng.uniform(0.0, 100.0)])),
                    "grey": int(m.rng.integers(0, 256)),
                }
            )
    return replace(m, row=replace(m.row, objects=tuple(objects)))


UNFRIENDLY_FACTORS: Mapping[str, Callable[[_Making], _Making]] = {
    "covers": _covers,
    "light": _light,
    "thickness": _thickness,
    "labels": _labels,
    "fonts": _fonts,
    "glare": _glare,
    "narrow": _narrow,
    "leaning": _leaning,
    "objects": _objects,
}
"""Functions that make a row harder, by name, in the order of their use; docstrings describe level 1."""


def no_slot(row: ShelfRow, book: GeneratedBook, spoilt: Mapping[int, str]) -> str:
    """Return why a lent book does not fit the gap in its row any more; empty if it fits.

    Args:
        row: row with the gap of the book.
        book: the lent book.
        spoilt: reasons known already for books that do not fit their gaps, by the book's accession number.
    """
    if book.accession in spoilt:
        return spoilt[book.accession]
    at = [i for i, item in enumerate(row.standing) if _is_slot(item)][row.lent.index(book)]
    beside = row.standing[max(0, at - 1) : at + 2]
    if any(isinstance(item, GeneratedBook) and item.lean_deg for item in beside):
        return "a neighbour leans away from it"
    play = _gaps(row)[row.lent.index(book)] - book.thickness_mm
    return "" if play >= LEAST_PLAY_MM else f"it is {play:.1f} mm wider than the book"


def _books(row: ShelfRow) -> list[GeneratedBook]:
    return [item for item in row.standing if isinstance(item, GeneratedBook)]


def _is_slot(each: GeneratedBook | float) -> TypeGuard[float]:
    return isinstance(each, float) and each >= _LEAST_SLOT_MM


def _gaps(row: ShelfRow) -> list[float]:
    return [item for item in row.standing if _is_slot(item)]


def _with_plays(m: _Making, plays: Mapping[int, float]) -> _Making:
    """Return the row with each slot wider than its book by the play given for the book's accession, in
    [mm].
    """
    gaps = iter([round(float(book.thickness_mm + plays[book.accession]), 2) for book in m.row.lent])
    standing = tuple(next(gaps) if _is_slot(item) else item for item in m.row.standing)
    return replace(m, row=replace(m.row, standing=standing))


def _fitted(m: _Making) -> _Making:
    """Return the row without the books farthest from slots, so that it fits its shelf."""
    standing: list[Any] = list(m.row.standing)
    while _width(standing) > 1e3 * CLEAR_WIDTH_M - 20.0:
        slots = [i for i, item in enumerate(standing) if _is_slot(item)]
        standing.pop(max(range(len(standing)), key=lambda i: min(abs(i - slot) for slot in slots)))
    return replace(m, row=replace(m.row, standing=tuple(standing)))


def _width(standing: Collection[GeneratedBook | float]) -> float:
    return sum(item if isinstance(item, float) else item.thickness_mm for item in standing)


def _gap_ends(row: ShelfRow, number: int) -> tuple[float, float]:
    """Return the start of a lent book's slot, from the left panel, and its width, in [mm]."""
    before, seen = 0.0, 0
    for item in row.standing:
        if _is_slot(item):
            if seen == number:
                return before, item
            seen += 1
        before += item if isinstance(item, float) else item.thickness_mm
    raise IndexError(number)


def _lean(standing: list[Any], number: int, count: int) -> None:
    """Let the books to the left of a slot lean into it, parallel to each other."""
    at = [i for i, item in enumerate(standing) if _is_slot(item)][number]
    gap, first = standing[at], standing[at - 1]
    angle = math.asin(min(0.6, gap / first.height_mm))
    for i in range(at - 1, max(-1, at - 1 - count), -1):
        if not isinstance(standing[i], GeneratedBook):
            break
        standing[i] = replace(standing[i], lean_deg=-round(math.degrees(angle) - 0.1, 1))
        if i < at - 1:
            standing.insert(i + 1, round(standing[i].thickness_mm * (1.0 / math.cos(angle) - 1.0) + 0.2, 2))
