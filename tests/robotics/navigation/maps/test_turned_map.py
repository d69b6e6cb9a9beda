"""Occupancy grids that are turned in their frame."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.maps.turned_map import is_level, turned_occupancy

ROOM = np.zeros((30, 40), dtype=np.int8)
ROOM[[0, -1]] = 100
ROOM[:, [0, -1]] = 100
ROOM[10:14, 20:25] = 100


@given(
    st.floats(-4.0, 4.0),
    st.floats(-50.0, 50.0),
    st.floats(-50.0, 50.0),
    st.integers(0, 39),
    st.integers(0, 29),
)
def test_middle_of_a_cell_is_within_half_a_cell(
    yaw: float, x: float, y: float, column: int, row: int
) -> None:
    """The middle of each old cell lies in a new one whose value came from at most a cell away."""
    corner = Pose2(x, y, yaw)
    turned = turned_occupancy(ROOM, 0.1, corner)
    middle = corner.apply(np.array([[0.1 * (column + 0.5), 0.1 * (row + 0.5)]]))[0]
    at = np.floor((middle - turned.origin) / 0.1).astype(int)
    value = turned.values[at[1], at[0]]
    near = ROOM[max(0, row - 1) : row + 2, max(0, column - 1) : column + 2]
    assert value in near or (value == -1 and (row in (0, 29) or column in (0, 39)))


@pytest.mark.parametrize("yaw", [0.3, -0.8, math.pi / 2, 3.0])
def test_turned_walls_stay_closed_and_as_long(yaw: float) -> None:
    turned = turned_occupancy(ROOM, 0.1, Pose2(2.0, -1.0, yaw))
    occupied = int((turned.values == 100).sum())
    assert occupied == pytest.approx(int((ROOM == 100).sum()), rel=0.05)
    free = turned.values == 0
    edge = np.zeros_like(free)
    edge[[0, -1]] = edge[:, [0, -1]] = True
    assert not (free & edge).any()  # nothing free at the border: the room does not leak


def test_turned_back_is_the_same() -> None:
    turned = turned_occupancy(ROOM, 0.1, Pose2(0.0, 0.0, math.pi))
    assert turned.values.tolist() == ROOM[::-1, ::-1].tolist()
    assert turned.origin == pytest.approx((-4.0, -3.0))


def test_turn_is_level_below_half_a_cell() -> None:
    assert is_level((30, 40), 0.0099)
    assert not is_level((30, 40), 0.0101)
    assert is_level((30, 40), 2.0 * math.pi)
