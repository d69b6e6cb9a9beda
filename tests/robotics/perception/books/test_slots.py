"""Slots between spines on painted strips: deep things shift from view to view."""

from __future__ import annotations

import numpy as np
import pytest

from handcart.robotics.perception.books.slots import Gap, find_slots
from handcart.robotics.perception.books.spine_edges import Strips
from handcart.robotics.perception.books.spines import SpineView

EYES = (0.04, -0.04)
LEFT, COLUMNS, ROWS, M_PER_PX = 0.10, 666, 40, 0.0003
INTERVAL = Gap(0.030, -0.030)
SOLID = ((0.060, 0.031), (-0.031, -0.060))
DEEPER = 0.25  # of an eye's way, by which what lies deep moves


def view(
    eye: float, deep: list[tuple[float, float]], edges: tuple[float, ...], shows: float = 45.0
) -> SpineView:
    """Two spines beside the interval; in it what lies deep, by how many grey levels it `shows`, and fronts
    where nothing does."""
    y = LEFT - np.arange(COLUMNS) * M_PER_PX
    row = 120.0 + 25.0 * np.sin(700.0 * y)
    for left, right in deep:
        inside = (y < left) & (y > right)
        row[inside] = 70.0 + shows * np.sin(400.0 * (y[inside] - DEEPER * eye) + 1.0)
    noise = np.random.default_rng(3 if eye > 0 else 4).normal(0.0, 1.0, (ROWS, COLUMNS))
    strips = Strips(row + noise, np.linspace(0.15, 0.0, ROWS), LEFT, M_PER_PX, -1)
    return SpineView((), edges, strips, eye, LEFT, -LEFT)


def slots(deep: list[tuple[float, float]], edges: tuple[float, ...]) -> list[Gap]:
    found = find_slots([view(eye, deep, edges) for eye in EYES], (0.0, 0.0), INTERVAL, SOLID)
    for slot in found:
        assert slot.left > slot.right
    return list(found)


def test_what_lies_deep_between_two_edges_is_free() -> None:
    (slot,) = slots([(0.010, -0.022)], (0.010, -0.022))
    assert tuple(slot) == pytest.approx((0.010, -0.022))


def test_what_hardly_shows_is_looked_at_from_far_enough_apart() -> None:
    """Two views from beside each other, as a round along the shelf may leave them, show it all but alike."""
    eyes = (0.04, -0.018, 0.010, -0.04)
    views = [view(eye, [(0.030, -0.030)], (), shows=8.0) for eye in eyes]
    assert not find_slots(views[1:3], (0.0,) * 2, INTERVAL, SOLID)
    assert find_slots(views, (0.0,) * 4, INTERVAL, SOLID) == (INTERVAL,)


def test_what_lies_in_the_front_is_not() -> None:
    assert slots([], (0.010, -0.022)) == []


def test_two_slots_have_a_book_between() -> None:
    first, second = slots([(0.030, 0.010), (-0.010, -0.030)], (0.010, -0.010))
    assert tuple(first) == pytest.approx((0.030, 0.010))
    assert tuple(second) == pytest.approx((-0.010, -0.030))


@pytest.mark.parametrize("edges", [(0.0065,), (-0.002, -0.0045), (-0.0195,)])
def test_a_piece_too_thin_to_compare_belongs_to_the_slot_beside_it(edges: tuple[float, ...]) -> None:
    """Edges that both views have by chance in one place cut a piece off, at either end or in its middle."""
    (slot,) = slots([(0.010, -0.022)], (0.010, *edges, -0.022))
    assert tuple(slot) == pytest.approx((0.010, -0.022))


def test_thin_pieces_between_books_are_no_slot() -> None:
    assert slots([], (0.010, 0.0065, 0.003, -0.022)) == []
