"""INSERT at its public face, on the kinematic backend."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from handcart.backends.simulation.books.book_props import BookProps
from handcart.primitives.books.insert import Insert
from handcart.primitives.outcomes.outcome import Fail, GiveUp, Success
from tests.primitives.conftest import Rig


def fronts(rig: Any) -> dict[int, float]:
    """x of the spines on the shelf, by accession, in [m]."""
    return {book.book.accession: book.front for book in rig.scene.of(BookProps).shelf_books("shelf_1")}


def spine(rig: Any) -> Any:
    """The held book's spine in the shelf frame, (3,) in [m]."""
    return (rig.scene.of(BookProps).shelves["shelf_1"].inverse_pose @ rig.scene.held.pose)[:3, 3]


@pytest.mark.slow
@pytest.mark.parametrize(("seed", "aside"), [(0, 0.0), (1, 0.004), (2, -0.004)])
def test_it_pushes_the_book_in_until_the_tips_stand_before_the_spines(
    at_slot: Callable[..., Rig], seed: int, aside: float
) -> None:
    rig = at_slot(aside, seed)
    before = fronts(rig)
    outcome = rig.run(Insert(shelf="shelf_1"))
    assert isinstance(outcome, Success)
    assert outcome.evidence["tries"] == 1
    assert spine(rig)[0] == pytest.approx(-0.037, abs=0.003)
    assert fronts(rig) == before
    assert abs(rig.robot.arm.hand_force()[1]) < 2.5  # it yields to the slot's sides


@pytest.mark.slow
@pytest.mark.parametrize("aside", [0.0085, -0.0085])
def test_a_book_that_jams_is_tried_beside(at_slot: Callable[..., Rig], aside: float) -> None:
    tries = [_inserted(at_slot(aside, seed)) for seed in range(4)]
    assert tries.count(0) == 0
    assert max(tries) > 1


def test_without_the_wiggle_it_is_pulled_back_and_a_fail(at_slot: Callable[..., Rig]) -> None:
    rig = at_slot(0.010)
    before, start = fronts(rig), spine(rig)
    outcome = rig.run(Insert(shelf="shelf_1", wiggle=False))
    assert isinstance(outcome, Fail)
    assert "jams" in outcome.reason
    assert fronts(rig) == before
    assert np.allclose(spine(rig), start, atol=1e-3)
    assert rig.scene.held.accession == 117


@pytest.mark.slow
def test_where_no_slot_is_no_wiggle_helps(at_slot: Callable[..., Rig]) -> None:
    rig, insert = at_slot(0.030), Insert(shelf="shelf_1")
    before = fronts(rig)
    outcome = rig.run(insert)
    assert isinstance(outcome, Fail)
    assert insert.evidence.facts["tries"] == 3
    (cause,) = insert.evidence.causes
    assert cause.reason == outcome.reason
    assert cause.measured is not None
    assert cause.measured.value is not None
    assert f"it resists with {cause.measured.value:.0f} N" in outcome.reason
    assert cause.measured.value > 7.0
    assert fronts(rig) == before


@pytest.mark.slow
def test_a_force_that_moves_neighbours_is_for_a_person(
    at_slot: Callable[..., Rig], monkeypatch: pytest.MonkeyPatch
) -> None:
    rig = at_slot(0.030)
    monkeypatch.setattr("handcart.primitives.books.insert.JAM_FORCE_N", 20.0)
    before = fronts(rig)
    outcome = rig.run(Insert(shelf="shelf_1", wiggle=False))
    assert isinstance(outcome, GiveUp)
    assert "may have pushed a neighbour back" in outcome.reason
    assert fronts(rig) != before


def test_an_empty_hand_has_nothing_to_insert(at_slot: Callable[..., Rig]) -> None:
    rig = at_slot()
    rig.robot.gripper.move(0.07)
    rig.drive(rig.robot.wait(1.0))
    outcome = rig.run(Insert(shelf="shelf_1"))
    assert isinstance(outcome, Fail)
    assert outcome.reason == "the hand is empty; it must hold book 117"


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2))
def test_a_cancel_in_the_slot_pulls_the_book_out(at_slot: Callable[..., Rig], seed: int) -> None:
    rig = at_slot(seed=seed)
    start = spine(rig)
    outcome = rig.run(Insert(shelf="shelf_1"), lambda: spine(rig)[0] > -0.10)
    assert isinstance(outcome, Fail)
    assert outcome.reason == "cancelled by the operator"
    assert np.allclose(spine(rig), start, atol=1e-3)


def test_taught_it_plays_back_postures(at_slot: Callable[..., Rig]) -> None:
    rig = at_slot()
    refused = rig.run(Insert(shelf="shelf_1", method="taught"))
    assert isinstance(refused, Fail)
    assert "insert_1" in refused.reason
    arm, spec = rig.robot.arm_model, rig.robot.spec
    assert spec.arm is not None
    near, postures = rig.robot.arm.command(), dict(spec.arm.postures)
    for number, ahead in enumerate((0.02, 0.16), start=1):
        hand = arm.forward(rig.robot.arm.command())
        hand[:3, 3] += ahead * hand[:3, 0]
        found = arm.inverse(hand, near)
        assert found is not None
        near = found
        postures[f"insert_{number}"] = tuple(np.degrees(near))
    taught = spec.arm.model_copy(update={"postures": postures})
    rig.robot.spec = spec.model_copy(update={"arm": taught})
    before = spine(rig)
    assert isinstance(rig.run(Insert(shelf="shelf_1", method="taught")), Success)
    assert spine(rig)[0] - before[0] == pytest.approx(0.16, abs=0.002)


def _inserted(rig: Any) -> int:
    """Tries that it took; 0 where it failed."""
    outcome = rig.run(Insert(shelf="shelf_1"))
    return int(outcome.evidence["tries"]) if isinstance(outcome, Success) else 0
