"""Pressing bodies, from contacts as MuJoCo gives them."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np

from handcart.backends.mujoco.engine.pressing import Pressing
from handcart.backends.physics.engine.engine import Touching

ROBOT, FLOOR, BOX = 0, 1, 2
OWNERS = [(ROBOT, 4), (FLOOR, -1), (BOX, -1), (ROBOT, 5)]
"""Owners of four geometries."""


def data(pairs: list[tuple[int, int]], forces: list[float]) -> Any:
    """Contacts of these geometries, each with one row of force."""
    rows = np.arange(len(pairs))
    contact = SimpleNamespace(geom=np.array(pairs, np.int32).reshape(-1, 2), efc_address=rows)
    return SimpleNamespace(contact=contact, efc_force=np.array(forces), nefc=len(forces))


def test_both_hear_of_it() -> None:
    pressing, now = Pressing(OWNERS), data([(1, 0), (2, 3)], [3.0, 1.0])
    assert pressing.touching(now, ROBOT) == {Touching(4, FLOOR, -1), Touching(5, BOX, -1)}
    assert pressing.touching(now, BOX) == {Touching(-1, ROBOT, 5)}


def test_what_comes_near_without_a_force_does_not_press() -> None:
    pressing = Pressing(OWNERS)
    assert pressing.touching(data([(1, 0), (2, 3)], [0.0, 1.0]), ROBOT) == {Touching(5, BOX, -1)}
    apart = data([(1, 0), (2, 3)], [1.0, 1.0])
    apart.contact.efc_address = np.array([-1, 0])
    assert pressing.touching(apart, ROBOT) == {Touching(5, BOX, -1)}


def test_the_same_geometries_may_press_no_longer() -> None:
    pressing, pairs = Pressing(OWNERS), [(1, 0), (2, 3)]
    assert len(pressing.touching(data(pairs, [1.0, 1.0]), ROBOT)) == 2
    before = pressing.touching(data(pairs, [2.0, 1.5]), ROBOT)
    assert pressing.touching(data(pairs, [2.0, 1.5]), ROBOT) is before
    assert pressing.touching(data(pairs, [0.0, 1.0]), ROBOT) == {Touching(5, BOX, -1)}
    assert not pressing.touching(data([], []), ROBOT)
