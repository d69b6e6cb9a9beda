"""APPROACH at its public face, on the kinematic backend."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from handcart.backends.simulation.books.book_props import BookProps
from handcart.primitives.books.approach import Approach
from handcart.primitives.books.books import Books
from handcart.primitives.outcomes.outcome import Fail, Success
from tests.primitives.conftest import Rig


def fore_edge(rig: Any) -> Any:
    """Foot of the held book's leading edge in the shelf frame, (3,) in [m]."""
    pose = rig.scene.of(BookProps).shelves["shelf_1"].inverse_pose @ rig.scene.held.pose
    return (pose @ np.array([rig.scene.held.depth, 0.0, 0.0, 1.0]))[:3]


def middle(rig: Any) -> float:
    """y of the true slot's middle in the shelf frame, in [m]."""
    books = rig.scene.of(BookProps).shelf_books("shelf_1")
    left, right = books[7], books[8]
    return float(left.lateral - left.book.thickness / 2 + right.lateral + right.book.thickness / 2) / 2


def off_by(rig: Any, error: float) -> None:
    """Put an error into what is known of the slot, beside that of the robot's pose."""
    slot = rig.model.of(Books).slot
    rig.model.of(Books).slot = slot._replace(left=slot.left + error, right=slot.right + error)


@pytest.mark.parametrize(("seed", "error"), [(0, 0.003), (1, -0.003), (2, 0.0)])
def test_it_brings_the_book_before_its_slot(at_slot: Callable[..., Rig], seed: int, error: float) -> None:
    rig = at_slot(0.05, seed)
    off_by(rig, error + _pose_error(rig))
    primitive = Approach(shelf="shelf_1")
    assert isinstance(rig.run(primitive), Success)
    x, y, z = fore_edge(rig)
    assert y == pytest.approx(middle(rig), abs=0.002)
    assert -0.045 < x < -0.025
    assert 0.004 < z < 0.008
    assert primitive.facts["corrected_mm"] == pytest.approx(-1e3 * error, abs=2.0)
    assert primitive.evidence.pictures["slot"].shape == (480, 640, 3)
    assert rig.scene.contacts == []


def test_without_correction_what_search_saw_counts(at_slot: Callable[..., Rig]) -> None:
    rig = at_slot(0.05)
    off_by(rig, 0.006 + _pose_error(rig))
    assert isinstance(rig.run(Approach(shelf="shelf_1", correct=False)), Success)
    assert fore_edge(rig)[1] == pytest.approx(middle(rig) + 0.006, abs=0.002)


def test_a_slot_that_is_not_there_is_a_fail_and_the_arm_back(at_slot: Callable[..., Rig]) -> None:
    rig = at_slot(0.05)
    off_by(rig, 0.060)
    before = rig.robot.arm.command()
    outcome = rig.run(Approach(shelf="shelf_1"))
    assert isinstance(outcome, Fail)
    assert outcome.reason == "the slot's side is not seen where SEARCH saw it: right of 510.7 ABE"
    assert np.array_equal(rig.robot.arm.command(), before)


def test_it_needs_a_slot_and_the_book_in_the_hand(at_slot: Callable[..., Rig]) -> None:
    rig = at_slot()
    slot, rig.model.of(Books).slot = rig.model.of(Books).slot, None
    outcome = rig.run(Approach(shelf="shelf_1"))
    assert isinstance(outcome, Fail)
    assert outcome.reason == "no slot is known on shelf_1"
    rig.model.of(Books).slot = slot
    books = rig.model.of(Books)
    assert books.book is not None
    books.book = books.book.model_copy(update={"thickness_mm": 40.0})
    outcome = rig.run(Approach(shelf="shelf_1"))
    assert isinstance(outcome, Fail)
    assert outcome.reason == ("the hand does not hold book 117: what it holds is 25.0 mm thick, not 40.0 mm")


def _pose_error(rig: Any) -> float:
    """Return the robot's error along the shelf in [m], which SEARCH would add to the slot."""
    return float(rig.scene.base.x - rig.robot.pose.x)
