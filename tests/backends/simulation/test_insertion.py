from __future__ import annotations

import math

import pytest

from handcart.backends.simulation.books.insertion import Entrance, Entry, entry_chance
from handcart.backends.simulation.books.row import Member
from handcart.backends.simulation.books.shelf import SimulatedShelf
from handcart.backends.simulation.books.spec import ShelfSpec

SHELF = SimulatedShelf(ShelfSpec(name="s", x_m=0, y_m=0))
# A slot of 33 mm about y = 0 between two fixed members.
ROW = [Member(-0.1, -0.0165, 0.0, 0.2, None), Member(0.0165, 0.1, 0.0, 0.2, None)]


def enter(lateral: float, yaw: float = 0.0, seed: int = 0, thickness: float = 0.025) -> Entry:
    entrance = Entrance(seed)
    # The book's middle is 75 mm behind its leading edge.
    edge = (0.001, lateral - 0.075 * math.sin(yaw), yaw)
    entry = entrance.follow(None, SHELF, ROW, edge, thickness)
    assert entry is not None
    return entry


@pytest.mark.parametrize(
    ("error_mm", "clearance_mm", "chance"),
    [(0, 8, 1.0), (6, 8, 1.0), (8, 8, 0.5), (10, 8, 0.0), (4, 4, 1.0), (8, 4, 0.0), (0, 0, 0.0)],
)
def test_the_chance_falls_from_certain_to_nothing_within_4_mm(
    error_mm: int, clearance_mm: int, chance: float
) -> None:
    assert entry_chance(error_mm / 1e3, clearance_mm / 1e3) == pytest.approx(chance)


@pytest.mark.parametrize("seed", range(5))
def test_lateral_error_and_yaw_work_together(seed: int) -> None:
    yaw = math.radians(5.0)
    assert enter(0.0, seed=seed).admitted
    assert enter(0.0065, yaw, seed).admitted
    assert not enter(-0.0065, yaw, seed).admitted
    assert not enter(0.011, seed=seed).admitted


def test_on_the_border_it_is_luck_that_the_seed_draws() -> None:
    lucky = [enter(0.008, seed=seed).admitted for seed in range(200)]
    assert 70 < sum(lucky) < 130
    assert lucky == [enter(0.008, seed=seed).admitted for seed in range(200)]


def test_a_book_thicker_than_the_slot_jams() -> None:
    assert not enter(0.0, thickness=0.034).admitted


def test_luck_is_drawn_once_an_entry_and_anew_after_withdrawing() -> None:
    entrance, edge = Entrance(0), (0.001, 0.008, 0.0)
    first = entrance.follow(None, SHELF, ROW, edge, 0.025)
    assert entrance.follow(first, SHELF, ROW, (0.05, 0.008, 0.0), 0.025) is first
    assert entrance.follow(first, SHELF, ROW, (-0.001, 0.008, 0.0), 0.025) is first
    assert entrance.follow(first, SHELF, ROW, (-0.003, 0.008, 0.0), 0.025) is None
    assert entrance.count == 1
    entrance.follow(None, SHELF, ROW, edge, 0.025)
    assert entrance.count == 2


def test_before_the_row_there_is_no_entry() -> None:
    assert Entrance(0).follow(None, SHELF, ROW, (-0.001, 0.0, 0.0), 0.025) is None
