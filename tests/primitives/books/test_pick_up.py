"""PICK_UP at its public face, on the kinematic backend."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from handcart.backends.simulation.books.book_props import BookProps
from handcart.primitives.books.books import Books
from handcart.primitives.books.pick_up import PickUp
from handcart.primitives.outcomes.outcome import Fail, GiveUp, Success
from tests.primitives.conftest import Rig

TRAY = "tray: {{accession: 117, call: 512.7 NAG, thickness_mm: {0}, height_mm: 210, depth_mm: 150}}\n"


@pytest.fixture
def with_book(make_rig: Callable[..., Rig]) -> Callable[..., Rig]:
    def make(seed: int = 0, thickness: int = 25) -> Rig:
        rig = make_rig(TRAY.format(thickness), seed=seed)
        rig.book_is_recognized()
        return rig

    return make


@pytest.mark.parametrize("seed", range(4))
def test_it_takes_the_book_by_the_rear_of_its_covers(with_book: Callable[..., Rig], seed: int) -> None:
    rig = with_book(seed)
    outcome = rig.run(PickUp())
    assert isinstance(outcome, Success)
    assert outcome.evidence["width_mm"] == pytest.approx(25.0, abs=0.3)
    assert rig.scene.held.accession == 117
    assert rig.scene.hand_T_held[:3, 3] == pytest.approx((0.12, 0.0, -0.12), abs=0.002)
    assert np.allclose(rig.robot.arm.command(), rig.robot.spec.posture("carry"))
    assert rig.scene.contacts == []


@pytest.mark.parametrize("aside", [0.004, -0.004])
def test_fingers_slide_a_book_that_stands_aside(with_book: Callable[..., Rig], aside: float) -> None:
    rig = with_book()
    pose = rig.model.of(Books).book_pose
    assert pose is not None
    rig.model.of(Books).book_pose = pose._replace(y=pose.y + aside)
    assert isinstance(rig.run(PickUp()), Success)
    assert abs(rig.scene.hand_T_held[1, 3]) < 0.001


def test_a_grip_of_nothing_is_a_fail_while_the_tag_is_where_it_was(with_book: Callable[..., Rig]) -> None:
    rig = with_book()
    pose = rig.model.of(Books).book_pose
    assert pose is not None
    rig.model.of(Books).book_pose = pose._replace(x=pose.x - 0.08)
    before = rig.scene.of(BookProps).book_pose(117).copy()
    outcome = rig.run(PickUp())
    assert isinstance(outcome, Fail)
    assert outcome.reason == "the fingers closed on nothing"
    assert outcome.residuals["object book mm"] < 3.0
    assert np.allclose(rig.scene.of(BookProps).book_pose(117), before)


@pytest.mark.slow
def test_a_grip_of_nothing_is_for_a_person_when_the_book_was_moved(with_book: Callable[..., Rig]) -> None:
    rig = with_book()
    pose = rig.model.of(Books).book_pose
    assert pose is not None
    rig.model.of(Books).book_pose = pose._replace(x=pose.x - 0.08)

    class Knocked(PickUp):
        def restore(self, *args: Any) -> Any:
            yield from super().restore(*args)
            rig.scene.of(BookProps).tray_book().base_T_thing[1, 3] += 0.015
            rig.scene.move_base(rig.scene.base)

    outcome = rig.run(Knocked())
    assert isinstance(outcome, GiveUp)
    assert "object book mm" in outcome.reason


def test_an_empty_tray_is_a_fail_that_the_hand_did_not_go_there_for(make_rig: Callable[..., Rig]) -> None:
    rig = make_rig(TRAY.format(25))
    rig.book_is_recognized()
    rig.scene.of(BookProps).books.clear()
    outcome = rig.run(PickUp())
    assert isinstance(outcome, Fail)
    assert "isn't seen" in outcome.reason


def test_another_thickness_is_set_down_where_it_was(with_book: Callable[..., Rig]) -> None:
    rig = with_book(thickness=33)
    before = rig.scene.of(BookProps).book_pose(117).copy()
    outcome = rig.run(PickUp())
    assert isinstance(outcome, Fail)
    assert outcome.reason == "the held object is 33 mm thick, not 25"
    assert np.allclose(rig.scene.of(BookProps).book_pose(117)[:3, 3], before[:3, 3], atol=1e-3)


@pytest.mark.parametrize("lifted", [0.0, 0.06, 0.11])
def test_a_cancel_sets_the_lifted_book_down_where_it_stood(
    with_book: Callable[..., Rig], lifted: float
) -> None:
    rig = with_book(seed=2)
    before = rig.scene.of(BookProps).book_pose(117).copy()
    height = before[2, 3] + lifted
    outcome = rig.run(
        PickUp(),
        lambda: rig.scene.held is not None and rig.scene.of(BookProps).book_pose(117)[2, 3] >= height - 1e-3,
    )
    assert isinstance(outcome, Fail)
    assert outcome.reason == "cancelled by the operator"
    assert rig.scene.held is None
    assert rig.scene.of(BookProps).tray_book() is not None
    assert np.allclose(rig.scene.of(BookProps).book_pose(117)[:3, 3], before[:3, 3], atol=2e-3)


def test_taught_it_plays_back_postures_and_trusts_them(with_book: Callable[..., Rig]) -> None:
    rig = with_book()
    missing = rig.run(PickUp(method="taught"))
    assert isinstance(missing, Fail)
    assert missing.permanent
    assert "pick_up_1" in missing.reason
    _teach(rig)
    assert isinstance(rig.run(PickUp(method="taught")), Success)
    assert rig.scene.held.accession == 117


def _teach(rig: Rig) -> None:
    """Record the postures that a planned grip goes through, as a person would by leading the hand."""
    arm, pose, arm_spec = rig.robot.arm_model, rig.model.of(Books).book_pose, rig.robot.spec.arm
    assert pose is not None
    assert arm_spec is not None
    at, near = [], np.array(rig.robot.spec.posture("carry"))
    for x, z in ((-0.17, 0.74), (-0.12, 0.74), (-0.12, 0.86)):
        hand = pose.lift(z)
        hand[:3, 3] += x * hand[:3, 0]
        found = arm.inverse(hand, near)
        assert found is not None
        near = found
        at.append(tuple(np.degrees(near)))
    postures = arm_spec.postures | {f"pick_up_{i + 1}": q for i, q in enumerate(at)}
    taught = arm_spec.model_copy(update={"postures": postures})
    rig.robot.spec = rig.robot.spec.model_copy(update={"arm": taught})


def test_another_book_on_the_tray_is_not_taken(with_book: Callable[..., Rig]) -> None:
    """The book was exchanged: its tag is another one."""
    rig = with_book()
    books = rig.model.of(Books)
    assert books.book is not None
    books.book = books.book.model_copy(update={"accession": 118})
    outcome = rig.run(PickUp())
    assert isinstance(outcome, Fail)
    assert outcome.reason == "the book isn't seen on the tray"
    assert rig.scene.held is None
