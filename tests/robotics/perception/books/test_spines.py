from __future__ import annotations

import numpy as np
import pytest

from handcart.robotics.perception.books.call_number import CallNumber, parse
from handcart.robotics.perception.books.label_reader import Label
from handcart.robotics.perception.books.spine_edges import Strips
from handcart.robotics.perception.books.spines import Spine, SpineView, scale_of

NUMBERS = [
    call_number
    for call_number in (parse(f"51{i} {c}AB") for i, c in enumerate("KLMNPRST"))
    if call_number is not None
]
THICKNESSES: dict[CallNumber, float] = {number: 0.02 + 0.004 * i for i, number in enumerate(NUMBERS)}


def spine(number: CallNumber | None, width: float, both: bool = True) -> Spine:
    return Spine(width, 0.0, Label(str(number), number, 0.9, np.zeros((4, 2)), 0.0, 0.035), both)


def view(*spines: Spine) -> SpineView:
    nothing = Strips(np.zeros((2, 2)), np.zeros(2), 0.1, 0.1, -1)
    return SpineView(spines, (), nothing, 0.0, 0.1, -0.1)


def wide(scale: float, count: int) -> list[Spine]:
    return [spine(number, scale * THICKNESSES[number]) for number in NUMBERS[:count]]


@pytest.mark.parametrize("scale", [0.97, 1.0, 1.04])
def test_books_of_known_thickness_tell_how_wide_everything_looks(scale: float) -> None:
    views = [view(*wide(scale, 4)), view(*wide(scale, 3))]
    assert scale_of(views, THICKNESSES) == pytest.approx(scale)


def test_few_books_tell_nothing() -> None:
    assert scale_of([view(*wide(1.04, 5))], THICKNESSES) == 1.0
    assert scale_of([view(*wide(1.04, 8))], {}) == 1.0


def test_only_what_was_seen_and_read_is_compared() -> None:
    """A side that wasn't seen was laid where the catalogue has it; an unread book has no thickness."""
    guessed = [spine(number, THICKNESSES[number], both=False) for number in NUMBERS]
    unread = [spine(None, 0.060) for _ in NUMBERS]
    assert scale_of([view(*wide(1.03, 6), *guessed, *unread)], THICKNESSES) == pytest.approx(1.03)
