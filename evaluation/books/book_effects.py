"""Effects that a Success of book primitives promises."""

from __future__ import annotations

import math
from collections.abc import Mapping

from handcart.backends.simulation.books.book import SimulatedBook
from handcart.backends.simulation.books.book_props import BookProps
from handcart.evaluation.judging.at_most import at_most
from handcart.evaluation.judging.survey import Claim, Effect, Survey
from handcart.primitives.books.books import Books
from handcart.robotics.geometry.transform import Transform, inverse
from handcart.robotics.perception.books.call_number import parse

from .shelving import Shelving, longest_rising

SEEN_MM = 8.0  # maximum distance of a seen book from its true place
SLOT_MM = 15.0  # the same of a slot's middle, along the shelf
EDGE_MM = 8.0  # that a leading edge may be beside the middle of its slot: further out it jams
PROUD_MM = 60.0  # maximum distance of a spine before the shelf after its book was inserted
NO_BOOK_HELD = "the hand holds no book"
APPROACH, RELEASE = "APPROACH", "RELEASE"


def _recognized(survey: Survey, _: Claim) -> list[str]:
    scene, model = survey.run.world, survey.run.model
    books = model.of(Books)
    book = scene.of(BookProps).tray_book()
    if book is None or books.book is None or books.book_pose is None:
        return ["no book stands on the tray, or none is known"]
    if book.accession != books.book.accession:
        return [f"book {book.accession} stands on the tray, not {books.book.accession}"]
    place = (inverse(scene.world_T_base) @ book.pose)[:2, 3]
    off = 1e3 * math.dist(place, books.book_pose[:2])
    return at_most("the book is {:.1f} mm from where it was seen", off, SEEN_MM)


def _picked_up(survey: Survey, _: Claim) -> list[str]:
    scene, model = survey.run.world, survey.run.model
    books = model.of(Books)
    held = scene.held.accession if isinstance(scene.held, SimulatedBook) else None
    wanted = books.book.accession if books.book else None
    return [] if held is not None and held == wanted else [f"the hand holds {held}, not {wanted}"]


def _searched(survey: Survey, _: Claim) -> list[str]:
    scene, model = survey.run.world, survey.run.model
    books = model.of(Books)
    slot = books.slot
    if slot is None or books.book is None:
        return ["no slot is known"]
    props = scene.of(BookProps)
    row = props.shelf_books(slot.shelf)
    middle = 0.5 * (slot.left + slot.right)
    sides = _gap_at(props, scene.held, slot.shelf, middle)
    wrong = at_most("the slot's middle is {:.1f} mm off", 1e3 * abs(middle - 0.5 * sum(sides)), SLOT_MM)
    at = sum(book.lateral > middle for book in row)
    calls = [book.book.spec.call for book in row]
    fits = _in_order(calls[:at], calls[at:], books.book.call)
    return wrong if fits else [*wrong, "the slot is not where the book belongs"]


def _held_before_shelf(survey: Survey, claim: Claim) -> tuple[SimulatedBook, Transform] | None:
    """Return the held book and its pose (4, 4) in the frame of the action's shelf; None if none is held."""
    held, books = survey.run.world.held, survey.run.world.of(BookProps)
    if not isinstance(held, SimulatedBook):
        return None
    return held, inverse(books.shelves[claim.primitive.shelf].pose) @ held.pose


def _approached(survey: Survey, claim: Claim) -> list[str]:
    found = _held_before_shelf(survey, claim)
    if found is None:
        return [NO_BOOK_HELD]
    held, pose = found
    edge = float(pose[1, 3] + pose[1, 0] * held.depth)
    middle = 0.5 * sum(_gap_at(survey.run.world.of(BookProps), held, claim.primitive.shelf, edge))
    return at_most(
        "the leading edge is {:.1f} mm beside its slot's middle", 1e3 * abs(edge - middle), EDGE_MM
    )


def _inserted(survey: Survey, claim: Claim) -> list[str]:
    found = _held_before_shelf(survey, claim)
    if found is None:
        return [NO_BOOK_HELD]
    held, pose = found
    books, middle = survey.run.world.of(BookProps), float(pose[1, 3])
    left, right = _gap_at(books, held, claim.primitive.shelf, middle)
    half = held.thickness / 2
    inside = right - 1e-3 <= pose[1, 3] - half and pose[1, 3] + half <= left + 1e-3
    wrong = [] if inside else ["the book isn't between the sides of a slot"]
    return wrong + at_most("the spine protrudes {:.1f} mm from the shelf", -1e3 * float(pose[0, 3]), PROUD_MM)


def _released(survey: Survey, _: Claim) -> list[str]:
    book = survey.run.model.of(Books).book
    stands = Shelving((book.accession,) if book else (), {}).judge(survey.run.world.of(BookProps))
    return [] if stands.right else [f"the book doesn't stand in its place: {stands}"]


def _in_order(left: list[str], right: list[str], own: str) -> bool:
    """Return whether a call number fits between the ordered call numbers to its left and right."""
    numbers = [(parse(call), at < len(left)) for at, call in enumerate(left + right)]
    known = [(number, is_left) for number, is_left in numbers if number is not None]
    row = [known[i] for i in longest_rising([number for number, _ in known])]
    wanted = parse(own)
    return wanted is not None and all((number < wanted) == is_left for number, is_left in row)


def _gap_at(books: BookProps, held: object, shelf: str, y: float) -> tuple[float, float]:
    """Return y of the left and right side, in the shelf's frame in [m], of the gap between books whose
    middles are on both sides of `y`.
    """
    half = books.shelves[shelf].half_width
    sides = [(right, left) for right, left, _ in books.shelves[shelf].fixed_intervals()]
    row = [book for book in books.shelf_books(shelf) if book.book is not held]
    half_books = [(book.lateral, book.book.thickness / 2) for book in row]
    sides += [(middle - half, middle + half) for middle, half in half_books]
    left = min((right for right, left in sides if 0.5 * (right + left) > y), default=half)
    right = max((left for right, left in sides if 0.5 * (right + left) <= y), default=-half)
    return left, right


BOOK_EFFECTS: Mapping[str, Effect] = {
    "RECOGNIZE": _recognized,
    "PICK_UP": _picked_up,
    "SEARCH": _searched,
    APPROACH: _approached,
    "INSERT": _inserted,
    RELEASE: _released,
}
"""Effects by the primitive's name."""
