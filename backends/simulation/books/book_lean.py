"""Tilt of a book in its row after its release."""

from __future__ import annotations

import math
from collections.abc import Sequence

from handcart.robotics.geometry.transform import Transform

from .book import SimulatedBook
from .row import Member
from .standing_book import leaned

MAX_LEAN_RAD = math.radians(45.0)  # a book that leans further slides down and lies


def lean_in_row(
    book: SimulatedBook, S_T_foot: Transform, row: Sequence[Member], wish: float
) -> Transform | None:
    """Return the pose (4, 4) in the shelf frame S of a book after the fingers released it; None if it falls
    flat.

    A book keeps the angle `wish` at which the fingers leave it, unless its centre of mass is beyond the lower
    edge on which it stands. In that case it tips further. In both cases the book stops at a neighbour: its
    upper edge meets a higher neighbour, or it leans on the edge of a lower one. Neighbours do not move, and
    friction keeps the foot in place.

    Args:
        book: released book.
        S_T_foot: (4, 4) pose of the book upright in its slot, in the shelf frame S.
        row: other members of the row.
        wish: angle at which the fingers leave the book, in [rad], positive to the left.
    """
    side = 1.0 if wish > 0.0 else -1.0
    stopped = _until_met(book, float(S_T_foot[1, 3]), row, side)
    tips = abs(wish) > math.atan2(book.thickness, book.height)
    angle = stopped if tips else min(abs(wish), stopped)
    if angle > MAX_LEAN_RAD:
        return None
    return leaned(S_T_foot, book.thickness, side * angle)


def _until_met(book: SimulatedBook, middle: float, row: Sequence[Member], side: float) -> float:
    """Return the angle, in [rad], at which a book that tips over to a side meets another member; at most a
    right angle.

    Args:
        book: book that tips over.
        middle: y of the book's middle in the shelf frame S, in [m].
        row: other members of the row.
        side: 1 for the left, -1 for the right.
    """
    beside = [(_gap(member, middle, side) - book.thickness / 2, member.top) for member in row]
    gap, top = min((item for item in beside if item[0] > -book.thickness / 2), default=(math.inf, 0.0))
    gap = max(0.0, gap)
    if gap >= book.height:
        return math.pi / 2
    met = math.asin(gap / book.height)
    return met if book.height * math.cos(met) <= top else math.atan2(gap, top)


def _gap(member: Member, middle: float, side: float) -> float:
    """Return the distance, in [m], from the book's middle to the near side of a member; negative if the
    member is on the other side.

    Args:
        member: member of the row.
        middle: y of the book's middle in the shelf frame S, in [m].
        side: 1 for the left, -1 for the right.
    """
    return member.right - middle if side > 0.0 else middle - member.left
