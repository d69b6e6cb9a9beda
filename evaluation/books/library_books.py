"""Books of generated libraries: sizes, call numbers, order."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from handcart.robotics.perception.books.call_number import parse

from .library_room import CLEAR_WIDTH_M

LABEL_FONTS = ("DejaVuSans", "DejaVuSans-Bold", "DejaVuSerif", "DejaVuSansMono")
LABEL_LETTERS = "ABCDEFGHIJKLMNOPRSTVWZ"
FEWEST_BETWEEN = 3  # books between two gaps, and between a gap and the row's end


@dataclass(frozen=True)
class GeneratedBook:
    """Book of a generated library, with its place, call number, size and appearance."""

    accession: int
    call: str
    shelf: str
    thickness_mm: float
    height_mm: int
    depth_mm: int
    grey: int
    font: str
    label_mm: float = 10.0
    label_lines: int = 1
    gloss: float = 0.0
    lean_deg: float = 0.0


@dataclass(frozen=True)
class ShelfRow:
    """Content of one shelf of a generated library, with books and gaps from left to right."""

    shelf: str
    standing: tuple[GeneratedBook | float, ...]
    lent: tuple[GeneratedBook, ...]
    """Books whose gaps are in the row, from left to right."""
    light: float = 0.1
    objects: tuple[dict[str, float], ...] = ()
    """Other objects, as in a world's file."""


def call_numbers(rng: np.random.Generator, count: int, first: int) -> list[str]:
    """Return `count` different random call numbers in library order, from `first` to below `first` + 100."""
    made: set[str] = set()
    while len(made) < count:
        whole = first + int(rng.integers(0, 100))
        decimals = ["", f".{rng.integers(1, 10)}", f".{rng.integers(10, 99)}"][int(rng.integers(0, 3))]
        made.add(f"{whole}{decimals} {''.join(rng.choice(list(LABEL_LETTERS), 3))}")
    ordered = sorted(((number, call) for call in made if (number := parse(call))), key=lambda item: item[0])
    return [call for _, call in ordered]


def make_row(
    rng: np.random.Generator, shelf: str, first_accession: int, first_call: int, misplaced: bool
) -> ShelfRow:
    """Return the books of a full shelf, of which two are lent and leave gaps.

    Args:
        rng: random generator.
        shelf: name of the shelf.
        first_accession: accession number of the first book; the others follow.
        first_call: whole part of the lowest possible call number; the call numbers of the row are at most 100
            above it.
        misplaced: True to put one book out of order, next to a gap.
    """
    thickness = rng.integers(15, 46, 60).astype(float)
    count = int(np.searchsorted(np.cumsum(thickness), 1e3 * CLEAR_WIDTH_M - 20.0))
    calls = call_numbers(rng, count, first_call)
    books = [
        GeneratedBook(
            first_accession + i,
            calls[i],
            shelf,
            thickness[i],
            int(rng.integers(180, 241)),
            int(rng.integers(120, 161)),
            int(rng.integers(70, 181)),
            LABEL_FONTS[int(rng.integers(0, len(LABEL_FONTS)))],
        )
        for i in range(count)
    ]
    places = _gap_places(rng, count)
    lent = tuple(books[i] for i in places)
    standing: list[GeneratedBook | float] = list(books)
    for i in places:
        standing[i] = books[i].thickness_mm + float(rng.integers(4, 9))
    if misplaced:
        standing = _misplace(rng, standing, places)
    return ShelfRow(shelf, tuple(standing), lent)


def _gap_places(rng: np.random.Generator, count: int) -> list[int]:
    """Return two places in a row of `count` books, away from each other and from both ends."""
    first = int(rng.integers(FEWEST_BETWEEN, count // 2 - 2))
    second = int(rng.integers(first + FEWEST_BETWEEN + 1, count - FEWEST_BETWEEN))
    return [first, second]


def _misplace(
    rng: np.random.Generator, standing: list[GeneratedBook | float], gaps: Sequence[int]
) -> list[GeneratedBook | float]:
    """Move one book to the far side of a gap, directly beside it and at least three places away.

    If it were nearer, the row would still read in order.
    """
    beside = int(rng.choice(list(gaps))) + int(rng.integers(0, 2))
    far = [
        i
        for i, item in enumerate(standing)
        if isinstance(item, GeneratedBook) and abs(i - beside) > FEWEST_BETWEEN
    ]
    taken = int(rng.choice(far))
    row = [*standing]
    book = row.pop(taken)
    row.insert(beside - 1 if taken < beside else beside, book)
    return row
