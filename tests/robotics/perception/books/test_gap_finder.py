from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from handcart.robotics.perception.books.call_number import CallNumber, parse
from handcart.robotics.perception.books.gap_finder import GapFound, NoGap, find_gap, ordered
from handcart.robotics.perception.books.shelf_views import ShelfBook, ShelfReading
from handcart.robotics.perception.books.slots import Gap


def _number(text: str) -> CallNumber:
    number = parse(text)
    assert number is not None
    return number


def _shelf(row: Sequence[CallNumber | str | float | None]) -> ShelfReading:
    """A reading of a row, from left to right: call numbers, None (unread book), widths of gaps in [m]."""
    y, books, gaps = 0.5, [], []
    for thing in row:
        width = thing if isinstance(thing, float) else 0.03
        if isinstance(thing, float):
            gaps.append(Gap(y, y - width))
        else:
            number = parse(thing) if isinstance(thing, str) else thing
            books.append(ShelfBook(y, y - width, number, 0.9, 3))
        y -= width
    return ShelfReading(tuple(books), tuple(gaps), ())


def _lent_and_misplaced(seed: int) -> tuple[ShelfReading, CallNumber, float]:
    """A shelf of 22 books less the wanted and two other lent ones, one book standing out of order.

    In half of the shelves it stands directly beside the wanted book's slot. Gives the reading, the wanted
    call number and the left side of its slot.
    """
    rng = np.random.default_rng(seed)
    numbers = [CallNumber("512", f"{n}", "ABC") for n in sorted(rng.choice(900, 22, replace=False) + 100)]
    wanted, *others = (int(i) for i in rng.permutation([2, 7, 12, 17])[:3] + rng.integers(0, 3, 3))
    row = [(number, 0.036 if i in (wanted, *others) else number) for i, number in enumerate(numbers)]
    while True:
        moved = int(rng.integers(0, 22))
        where = int(rng.integers(0, 22))
        if rng.random() < 0.5:
            where = wanted + int(rng.integers(-1, 2))
        mixed = row[:moved] + row[moved + 1 :]
        mixed.insert(where, row[moved])
        standing = [thing for _, thing in mixed if isinstance(thing, CallNumber)]
        if isinstance(row[moved][1], CallNumber) and standing != sorted(standing):
            break
    widths = [thing if isinstance(thing, float) else 0.03 for _, thing in mixed]
    before = [number for number, _ in mixed].index(numbers[wanted])
    return _shelf([thing for _, thing in mixed]), numbers[wanted], 0.5 - sum(widths[:before])


def test_the_right_gap_on_100_shelves_with_a_misplaced_book() -> None:
    hits = naive = 0
    for seed in range(100):
        reading, wanted, place = _lent_and_misplaced(seed)
        found = find_gap(reading, wanted, 0.03)
        hits += isinstance(found, GapFound) and found.left == pytest.approx(place)
        found = find_gap(reading, wanted, 0.03, misplacement=False)
        naive += isinstance(found, GapFound) and found.left == pytest.approx(place)
    assert hits == 100
    assert naive < 85


def test_misplaced_neighbour_of_the_gap_fools_only_naive_search() -> None:
    reading = _shelf(["510 AAA", "511 AAA", "899 ZZZ", 0.036, "513 AAA", "514 AAA"])
    found = find_gap(reading, _number("512 AAA"), 0.03)
    assert isinstance(found, GapFound)
    assert (found.before, found.after) == (parse("511 AAA"), parse("513 AAA"))
    assert found.misplaced == (parse("899 ZZZ"),)
    assert found.width == pytest.approx(0.036)
    assert isinstance(find_gap(reading, _number("512 AAA"), 0.03, misplacement=False), NoGap)


def test_unread_books_are_allowed_but_not_beside_the_slot() -> None:
    row: list[str | float | None] = ["510 AAA", None, "511 AAA", 0.035, "513 AAA", None]
    assert isinstance(find_gap(_shelf(row), _number("512 AAA"), 0.03), GapFound)
    rows: tuple[list[str | float | None], ...] = (
        ["511 AAA", None, 0.035, "513 AAA"],
        ["511 AAA", 0.035, None, "513 AAA"],
    )
    for beside in rows:
        found = find_gap(_shelf(beside), _number("512 AAA"), 0.03)
        assert isinstance(found, NoGap)
        assert "beside the slot there stands a book whose label can't be read" in found.reason
        assert found.is_unread


def test_of_two_slots_the_one_that_fits_best_is_taken() -> None:
    """Another copy of it stands between them."""
    rows: tuple[list[str | float | None], ...] = (
        ["511 AAA", 0.039, "512 AAA", 0.033, "513 AAA"],
        ["511 AAA", 0.033, "512 AAA", 0.039, "513 AAA"],
    )
    for row in rows:
        found = find_gap(_shelf(row), _number("512 AAA"), 0.03)
        assert isinstance(found, GapFound)
        assert found.width == pytest.approx(0.033)


@pytest.mark.parametrize(
    "row, reason",
    [
        (["511 AAA", "513 AAA", 0.036, "514 AAA"], "between 511 AAA and 513 AAA, and there is no free slot"),
        (["511 AAA", 0.025, "513 AAA"], "25 mm wide, too narrow for a book of 30 mm"),
        (["511 AAA", 0.080, "513 AAA"], "80 mm wide, so wide that the book would fall over"),
        (["513 AAA", 0.036, "514 AAA"], "to the left of 513 AAA"),
        (["510 AAA", 0.036, "511 AAA"], "to the right of 511 AAA"),
        ([None, 0.036, None], "no call number could be read"),
        ([], "no call number could be read"),
    ],
)
def test_no_gap_says_why(row: list[str | float | None], reason: str) -> None:
    found = find_gap(_shelf(row), _number("512 AAA"), 0.03)
    assert isinstance(found, NoGap)
    assert reason in found.reason
    assert found.is_unread is reason.startswith("no call number")


def test_longest_order_of_a_sequence() -> None:
    numbers = [_number(f"{n} AAA") for n in (3 * 100, 101, 102, 900, 103, 104)]
    assert [int(n.dewey) for n in ordered(numbers)] == [101, 102, 103, 104]
    assert ordered([]) == []
