"""Row of books as a hand from the front meets it: places, and how the books yield."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

from handcart.backends.simulation.world.hand_rule import ARM_STIFFNESS_N_M, FORCE_CAP
from handcart.backends.simulation.world.thing import Thing

from .book import SimulatedBook
from .books_there import BooksThere
from .shelf import SHELF_DEPTH_M, SimulatedShelf

PUSH_FRICTION = 3.0  # of a standing book pushed on its spine [N]
JAM_FRICTION = 10.0  # of a book pushed back by an edge that jams against it [N]
_LEAST_OVERLAP = 3e-4
_DEEP = 0.035  # behind the board's front edge [m]: further back than a book end, nothing bounds a slot


class Member(NamedTuple):
    """A book, panel or book end in a row of books on a shelf, with its bounds in the shelf frame S, in [m].

    `right` and `left` are its bounds along y, with `right` < `left`; `front` is the x of its spine or front,
    and `top` the z of its upper edge.
    """

    right: float
    left: float
    front: float
    top: float
    book: SimulatedBook | None
    """The book; None for a panel or the book end, which nothing moves."""


class FreeInterval(NamedTuple):
    """Free interval between two neighbours in a row of books on a shelf (books, panels or book ends).

    It reaches from `right` to `left` along y of the shelf frame S, in [m].
    """

    right: float
    left: float
    front: float
    """x in the frame S, in [m], beyond which a book's leading edge is in the interval."""

    @property
    def middle(self) -> float:
        """Middle of the free interval, as y in the shelf frame S, in [m]."""
        return (self.right + self.left) / 2

    @property
    def width(self) -> float:
        """Width of the interval, in [m]."""
        return self.left - self.right


class Pusher(NamedTuple):
    """Front face of the hand, or of a held book, that is pushed into a row of books; in the shelf frame S, in
    [m].

    The face is at x = `lead`, and extends from `right` to `left` along y and from `low` to `high` along z.
    """

    lead: float
    right: float
    left: float
    low: float
    high: float
    friction: float
    """Force with which each book that it meets resists, in [N]."""


class Push(NamedTuple):
    """Result of pushing against a row of books, with the final position, the force, and the objects that were
    met.

    `lead` is the x of the pusher's face in the shelf frame S, in [m]; `force` the size of the force on the
    face, in [N]; `met` has the names of the books or panels in the row that the face met.
    """

    lead: float
    force: float
    met: tuple[str, ...]


def members(books: BooksThere, shelf: SimulatedShelf, without: Thing | None) -> list[Member]:
    """Return the members of a shelf's row from right to left: side panels, book end and books.

    Args:
        books: books and shelves of the scene.
        shelf: shelf of the row.
        without: book that is left out, because the hand holds it; None: no book.
    """
    row = [Member(right, left, front, 0.35, None) for right, left, front in shelf.fixed_intervals()]
    row += [
        Member(*book.sides, book.front, book.book.height, book.book)
        for book in books.shelf_books(shelf.name)
        if book.book is not without
    ]
    return sorted(row, key=lambda member: member.right)


def slots(row: Sequence[Member]) -> list[FreeInterval]:
    """Return the free intervals between the members of a row (books, panels and book ends on a shelf).

    Objects that are more than 35 mm behind the shelf's front do not bound an interval. Such an object stops a
    book only after the book has entered the slot.
    """
    before = [member for member in row if member.front < _DEEP]
    return [
        FreeInterval(a.left, b.right, min(a.front, b.front))
        for a, b in pairwise(before)
        if b.right - a.left > 1e-4
    ]


def push(
    books: BooksThere, shelf: SimulatedShelf, row: Sequence[Member], pusher: Pusher, start: float
) -> Push:
    """Push a row of books with a face of the hand or of a held book, and move the books that yield.

    The face is commanded from `start` to `pusher.lead`. The motion is quasi-static. The arm is a spring with
    the stiffness `ARM_STIFFNESS_N_M` between command and face. Each book that the face meets resists with its
    friction; books at the shelf's back, panels and book end do not move.

    Args:
        books: books and shelves of the scene.
        shelf: shelf of the row.
        row: members of the row.
        pusher: face that pushes, at its commanded position.
        start: x of the face in the shelf frame S before the motion, in [m].

    Returns:
        Where the face ends, the force on it, and the names of the books and panels that it met.
    """
    met = [m for m in row if _meets(m, pusher, start)]
    met.sort(key=lambda member: member.front)
    lead, resist, moved = pusher.lead, 0.0, []
    for member in met:
        if member.front >= lead:
            break
        moved.append(member)
        resist += pusher.friction if member.book is not None else math.inf
        lead = max(member.front, pusher.lead - resist / ARM_STIFFNESS_N_M)
        ends = [SHELF_DEPTH_M - m.book.depth for m in moved if m.book is not None]
        lead = min([lead, *(max(end, m.front) for end, m in zip(ends, moved, strict=False))])
    if not moved:
        return Push(lead, 0.0, ())
    _move(books, shelf, moved, lead)
    names = tuple(f"book {m.book.accession}" if m.book else f"panel of {shelf.name}" for m in moved)
    return Push(lead, min(FORCE_CAP, ARM_STIFFNESS_N_M * (pusher.lead - lead)), names)


def _meets(member: Member, pusher: Pusher, start: float) -> bool:
    beside = min(member.left, pusher.left) - max(member.right, pusher.right) > _LEAST_OVERLAP
    level = pusher.high > 0.0 and pusher.low < member.top
    return beside and level and member.front > start - 0.005


def _move(books: BooksThere, shelf: SimulatedShelf, moved: Sequence[Member], lead: float) -> None:
    for member in moved:
        if member.book is not None and lead > member.front + 1e-9:
            member.book.pose = member.book.pose.copy()
            member.book.pose[:3, 3] += shelf.pose[:3, 0] * (lead - member.front)
            books.scene.changes += 1
