"""Search for a book's slot on a shelf."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from typing import NamedTuple

from handcart.robotics.perception.books.call_number import CallNumber
from handcart.robotics.perception.books.shelf_views import ShelfReading
from handcart.robotics.perception.books.slots import Gap

_LEAST_EXTRA = 0.002


class GapFound(NamedTuple):
    """Slot that was found for a book.

    `left` > `right` are y of its edges in the shelf frame, in [m]. `before` and `after` are the nearest call
    numbers on both sides that are in order, None at an end of the row. `misplaced` are call numbers that are
    out of order.
    """

    left: float
    right: float
    before: CallNumber | None
    after: CallNumber | None
    misplaced: tuple[CallNumber, ...] = ()

    @property
    def centre(self) -> float:
        """y of the middle between the gap's edges, in the shelf frame, in [m]."""
        return (self.left + self.right) / 2

    @property
    def width(self) -> float:
        """Distance between the gap's edges, in [m]."""
        return self.left - self.right


class NoGap(NamedTuple):
    """Reason why a book has no slot, as text and as a measured value with its unit and limit.

    `at` is y, in the shelf frame in [m], of the position at which the book belongs, None if unknown.
    `is_unread` is True if there may be a slot, but the books next to the slot could not be read or seen.
    """

    reason: str
    what: str
    value: float
    limit: float
    unit: str = ""
    at: float | None = None
    is_unread: bool = False


def find_gap(
    reading: ShelfReading,
    call_number: CallNumber,
    thickness: float,
    max_extra: float = 0.010,
    misplacement: bool = True,
) -> GapFound | NoGap:
    """Return the slot for a book in the order of call numbers, 2 mm to `max_extra` wider than the book.

    The right place is where the most books are in order. To its left, these are the books in a longest
    non-decreasing subsequence of call numbers up to `call_number`; to its right, those in such a subsequence
    of call numbers from `call_number` on. All other books are misplaced. An unread book may be anywhere,
    except directly next to the slot: there it might belong on the slot's other side, and no slot is returned.

    Args:
        reading: books and gaps of the shelf.
        call_number: call number of the book to insert.
        thickness: thickness of the book, in [m].
        max_extra: largest width of the slot beyond the thickness, in [m].
        misplacement: False to check only the two books read next to each slot.
    """
    numbers = [book.call_number for book in reading.books]
    if all(number is None for number in numbers):
        return NoGap("no call number could be read on the shelf", "call numbers read", 0, 1, is_unread=True)
    places = _best_places(numbers, call_number) if misplacement else _naive_places(numbers, call_number)
    if not places:
        return NoGap(f"no two neighbours on the shelf enclose {call_number}", "places for it", 0, 1)
    slots = [gap for gap in reading.gaps if _index(reading, gap) in places]
    before, after = _neighbours(numbers, call_number, places)
    where = _where(before, after)
    if not slots:
        reason = f"{call_number} belongs {where}, and there is no free slot"
        return NoGap(reason, "slots seen there", 0, 1, at=_at(reading, places[0]))
    fitting = [gap for gap in slots if _LEAST_EXTRA <= gap.width - thickness <= max_extra]
    if not fitting:
        slot = max(slots, key=lambda gap: gap.width)
        widest, least = slot.width * 1e3, (thickness + _LEAST_EXTRA) * 1e3
        trouble = "too narrow" if widest < least else "so wide that the book would fall over"
        return NoGap(
            f"{call_number} belongs {where}; the slot there is {widest:.0f} mm wide, {trouble} "
            f"for a book of {thickness * 1e3:.0f} mm",
            "width of the slot",
            widest,
            least if widest < least else (thickness + max_extra) * 1e3,
            "mm",
            (slot.left + slot.right) / 2,
        )
    chosen = min(fitting, key=lambda gap: gap.width)
    place = _index(reading, chosen)
    unread = sum(number is None for number in numbers[max(0, place - 1) : place + 1])
    if unread:
        reason = (
            f"{call_number} belongs {where}; beside the slot there stands a book whose label can't be read"
        )
        return NoGap(reason, "books beside it that aren't read", unread, 0, at=chosen.left, is_unread=True)
    before, after = _neighbours(numbers, call_number, [place])
    return GapFound(chosen.left, chosen.right, before, after, _misplaced(numbers, call_number, place))


def _index(reading: ShelfReading, gap: Gap) -> int:
    """Return the number of books to the left of a gap."""
    return sum(book.centre > (gap.left + gap.right) / 2 for book in reading.books)


def _at(reading: ShelfReading, place: int) -> float | None:
    """Return y, in the shelf frame in [m], of a book inserted at a place between its neighbours."""
    sides = [book.right for book in reading.books[:place][-1:]] + [
        book.left for book in reading.books[place : place + 1]
    ]
    return sum(sides) / len(sides) if sides else None


def _best_places(numbers: Sequence[CallNumber | None], wanted: CallNumber) -> list[int]:
    """Return the insertion places (0 to n) that leave the most books in order."""
    scores = [
        len(ordered(_only(numbers[:place], below=wanted)))
        + len(ordered(_only(numbers[place:], above=wanted)))
        for place in range(len(numbers) + 1)
    ]
    return [place for place, score in enumerate(scores) if score == max(scores)]


def _naive_places(numbers: Sequence[CallNumber | None], wanted: CallNumber) -> list[int]:
    """Return the places whose next reads on both sides enclose the wanted one."""
    places = []
    for place in range(len(numbers) + 1):
        left = next((n for n in reversed(numbers[:place]) if n is not None), None)
        right = next((n for n in numbers[place:] if n is not None), None)
        if (left is None or left <= wanted) and (right is None or wanted <= right):
            places.append(place)
    return places


def _only(
    numbers: Sequence[CallNumber | None], below: CallNumber | None = None, above: CallNumber | None = None
) -> list[CallNumber]:
    return [
        n
        for n in numbers
        if n is not None and (below is None or n <= below) and (above is None or n >= above)
    ]


def ordered(numbers: Sequence[CallNumber]) -> list[CallNumber]:
    """Return a longest non-decreasing subsequence of call numbers, found by patience sorting."""
    tops: list[CallNumber] = []
    chains: list[tuple[CallNumber, ...]] = []
    for number in numbers:
        pile = bisect_right(tops, number)
        chain = (*(chains[pile - 1] if pile else ()), number)
        tops[pile : pile + 1], chains[pile : pile + 1] = [number], [chain]
    return list(chains[-1]) if chains else []


def _neighbours(
    numbers: Sequence[CallNumber | None], wanted: CallNumber, places: Sequence[int]
) -> tuple[CallNumber | None, CallNumber | None]:
    """Return the ordered reads next to the places, on the left and on the right."""
    left = ordered(_only(numbers[: min(places)], below=wanted))
    right = ordered(_only(numbers[max(places) :], above=wanted))
    return (left[-1] if left else None), (right[0] if right else None)


def _misplaced(
    numbers: Sequence[CallNumber | None], wanted: CallNumber, place: int
) -> tuple[CallNumber, ...]:
    """Return the reads that belong to no longest ordered sequence around the place."""
    in_order = [
        *ordered(_only(numbers[:place], below=wanted)),
        *ordered(_only(numbers[place:], above=wanted)),
    ]
    return tuple(n for n in numbers if n is not None and n not in in_order)


def _where(before: CallNumber | None, after: CallNumber | None) -> str:
    if before is not None and after is not None:
        return f"between {before} and {after}"
    return f"to the right of {before}" if before is not None else f"to the left of {after}"
