"""Judge the places of books by the ground truth."""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from handcart.backends.simulation.books.book_props import BookProps
from handcart.robotics.perception.books.call_number import CallNumber, parse

MOST_PROUD_MM = 10.0
MOST_PUSHED_MM = 10.0
MOST_TILT_DEG = 5.0


class ShelvedBooks(NamedTuple):
    """Errors of returned books in slot, protrusion and tilt, and by how far they pushed others back; each
    value is the worst of all returned books, in the unit that ends its name.
    """

    slot_correct: bool
    proud_mm: float
    """Distance by which the book's spine protrudes beyond the line of its neighbours' spines."""
    tilt_deg: float
    pushed_mm: float
    """Largest distance by which any other book of the shelf was pushed back."""

    @property
    def right(self) -> bool:
        """True if the books are in the correct slots and within the limits for protrusion, tilt and push."""
        return (
            self.slot_correct
            and abs(self.proud_mm) <= MOST_PROUD_MM
            and self.tilt_deg <= MOST_TILT_DEG
            and self.pushed_mm <= MOST_PUSHED_MM
        )

    def figures(self) -> dict[str, Any]:
        """Return the quality of shelving as metrics of a run; a value that is undefined, because a book is on
        no shelf, is left out.
        """
        fields = self._asdict()
        return {
            name: value if isinstance(value, bool) else round(value, 2)
            for name, value in fields.items()
            if not (isinstance(value, float) and math.isnan(value))
        }


@dataclass(frozen=True)
class Shelving:
    """Evaluation of how well books were returned to shelves, by comparison with the shelves' initial
    state.
    """

    accessions: tuple[int, ...]
    fronts: Mapping[int, float]
    """x of each standing book's spine in the frame of its shelf, by accession number, in [m]."""

    def judge(self, books: BookProps) -> ShelvedBooks:
        """Return how well the books that the robot has to return (`accessions`) are shelved at present."""
        pushed = self._pushed(books)
        each = [self._judge(books, number, pushed) for number in self.accessions]
        return ShelvedBooks(
            all(one.slot_correct for one in each),
            max((one.proud_mm for one in each), key=abs),
            max(one.tilt_deg for one in each),
            pushed,
        )

    def _judge(self, books: BookProps, accession: int, pushed: float) -> ShelvedBooks:
        book = books.books.get(accession)
        if book is None or book.shelf is None:
            return ShelvedBooks(False, math.nan, math.nan, pushed)
        row = books.shelf_books(book.shelf)
        at = next(i for i, standing_book in enumerate(row) if standing_book.book.accession == accession)
        beside = [row[i].front for i in (at - 1, at + 1) if 0 <= i < len(row)]
        proud = 1e3 * (sum(beside) / len(beside) - row[at].front) if beside else math.nan
        tilt = math.degrees(max(abs(row[at].tilt), abs(row[at].yaw)))
        return ShelvedBooks(_in_order(row, at), proud, tilt, pushed)

    def _pushed(self, books: BookProps) -> float:
        now = {book.book.accession: book.front for name in books.shelves for book in books.shelf_books(name)}
        return 1e3 * max((now[number] - front for number, front in self.fronts.items()), default=0.0)


def shelving(books: BookProps, accessions: tuple[int, ...]) -> Shelving:
    """Record the initial positions of all spines, to judge later how the given books were returned.

    Args:
        books: books and shelves of the simulation.
        accessions: accession numbers of the books to return.
    """
    fronts = {book.book.accession: book.front for name in books.shelves for book in books.shelf_books(name)}
    return Shelving(accessions, fronts)


def _in_order(row: Sequence[Any], at: int) -> bool:
    """Return whether the book at `at` is between its correct neighbours, among those that are in order."""
    numbers = [parse(item.book.spec.call) for item in row]
    wanted = numbers[at]
    others = [i for i in range(len(row)) if i != at and numbers[i] is not None]
    ordered = [others[i] for i in longest_rising([_known(numbers[i]) for i in others])]
    before = [i for i in ordered if _known(numbers[i]) < _known(wanted)]
    return all(i < at for i in before) and all(i > at for i in ordered if i not in before)


def _known(number: CallNumber | None) -> CallNumber:
    assert number is not None
    return number


def longest_rising(values: Sequence[CallNumber]) -> list[int]:
    """Return the indices of a longest strictly rising subsequence (patience sorting)."""
    tops: list[CallNumber] = []
    top_at: list[int] = []
    before: list[int | None] = []
    for i, value in enumerate(values):
        pile = bisect_left(tops, value)
        before.append(top_at[pile - 1] if pile else None)
        tops[pile : pile + 1] = [value]
        top_at[pile : pile + 1] = [i]
    result: list[int] = []
    last: int | None = top_at[-1] if top_at else None
    while last is not None:
        result.append(last)
        last = before[last]
    return result[::-1]
