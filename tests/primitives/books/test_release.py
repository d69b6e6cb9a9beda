"""RELEASE at its public face, on the kinematic backend."""

from __future__ import annotations

import math
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from handcart.backends.backend import CommandError
from handcart.backends.simulation.books.book_props import BookProps
from handcart.backends.simulation.world.thing import Rest
from handcart.primitives.books.books import Books
from handcart.primitives.books.catalogue import Book
from handcart.primitives.books.insert import Insert
from handcart.primitives.books.release import Release
from handcart.primitives.outcomes.outcome import Fail, GiveUp, Success
from handcart.robotics.perception.books.call_number import parse
from handcart.robotics.perception.books.label_reader import Label
from tests.primitives.conftest import Rig


@pytest.fixture
def inserted(at_slot: Callable[..., Rig]) -> Callable[..., Rig]:
    def make(seed: int = 0) -> Rig:
        rig = at_slot(seed=seed)
        assert isinstance(rig.run(Insert(shelf="shelf_1")), Success)
        return rig

    return make


def standing(rig: Rig, accession: int) -> Any:
    """Return the book on the shelf; None if it is not there."""
    found = [
        book for book in rig.scene.of(BookProps).shelf_books("shelf_1") if book.book.accession == accession
    ]
    return found[0] if found else None


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_the_book_stands_in_its_slot_flush_with_its_neighbours(
    inserted: Callable[..., Rig], seed: int
) -> None:
    rig = inserted(seed)
    others = {
        shelf_book.book.accession: shelf_book.front
        for shelf_book in rig.scene.of(BookProps).shelf_books("shelf_1")
    }
    outcome = rig.run(Release(shelf="shelf_1"))
    assert isinstance(outcome, Success)
    book = standing(rig, 117)
    assert abs(book.front) < 0.003
    assert book.yaw == pytest.approx(0.0)
    assert book.tilt < math.radians(0.5)
    assert standing(rig, 17).lateral > book.lateral > standing(rig, 20).lateral
    assert all(standing(rig, accession).front == front for accession, front in others.items())
    assert outcome.evidence["proud_mm"] == pytest.approx(-1e3 * book.front, abs=1.5)
    assert np.allclose(rig.robot.arm.command(), rig.robot.spec.posture("home"))


@pytest.mark.slow
def test_before_the_fingers_open_everything_can_be_undone(inserted: Callable[..., Rig]) -> None:
    rig = inserted()
    height = rig.scene.held.pose[2, 3]
    outcome = rig.run(Release(shelf="shelf_1"), lambda: rig.scene.held.pose[2, 3] < height - 0.003)
    assert isinstance(outcome, Fail)
    assert rig.scene.held.pose[2, 3] == pytest.approx(height, abs=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("opened", [0.0254, 0.036])
def test_cancel_after_opening_is_a_give_up_and_the_hand_withdraws(
    inserted: Callable[..., Rig], opened: float
) -> None:
    rig = inserted()
    gripper = rig.robot.gripper
    outcome = rig.run(Release(shelf="shelf_1"), lambda: max(gripper.command(), gripper.width()) > opened)
    assert isinstance(outcome, GiveUp)
    assert "after a point of no return (the fingers let the book go)" in outcome.reason
    assert standing(rig, 117) is not None
    assert np.allclose(rig.robot.arm.command(), rig.robot.spec.posture("home"))


@pytest.mark.slow
@pytest.mark.parametrize("stage", ["opening", "open", "pushed"])
def test_refused_command_after_opening_is_a_success_if_it_is_read(
    inserted: Callable[..., Rig], monkeypatch: pytest.MonkeyPatch, stage: str
) -> None:
    """It is pushed home all the same, and its label read between the right neighbours."""
    rig = inserted()
    robot, release, left = rig.robot, Release(shelf="shelf_1"), [0]

    def refusing(command: Any) -> Any:
        def commanded(*given: Any) -> None:
            left[0] -= 1
            if left[0] == 0:
                raise CommandError("refused")
            command(*given)

        return commanded

    for actuator in (robot.arm, robot.gripper):
        monkeypatch.setattr(actuator, "move", refusing(actuator.move))

    def refuse_next() -> bool:
        begun = {
            "opening": release._open_to is not None and release._no_return is not None,
            "open": release._no_return is not None and release._open_to is None,
            "pushed": release._is_home,
        }
        if begun[stage] and left[0] <= 0 and "refused" not in refusals:
            refusals.append("refused")
            left[0] = 1
        return False

    refusals: list[str] = []
    outcome = rig.run(release, refuse_next)
    assert refusals
    assert isinstance(outcome, Success), outcome
    assert outcome.evidence["finished_after"] == "CommandError: refused"
    assert abs(standing(rig, 117).front) < 0.003
    assert np.allclose(robot.arm.command(), robot.spec.posture("home"))


@pytest.mark.slow
def test_a_label_that_is_not_read_in_the_slot_is_for_a_person(inserted: Callable[..., Rig]) -> None:
    rig = inserted()
    books = rig.model.of(Books)
    assert books.book is not None
    books.book = books.book.model_copy(update={"call": "533.1 OHM"})
    outcome = rig.run(Release(shelf="shelf_1"))
    assert isinstance(outcome, GiveUp)
    assert "the effect is not seen" in outcome.reason


@pytest.mark.slow
def test_a_book_between_the_wrong_neighbours_is_for_a_person(inserted: Callable[..., Rig]) -> None:
    rig = inserted()
    books = rig.model.of(Books)
    assert books.slot is not None
    books.slot = books.slot._replace(after=books.slot.before, before=books.slot.after)
    assert isinstance(rig.run(Release(shelf="shelf_1")), GiveUp)


def test_where_no_board_is_the_book_is_not_let_go(at_slot: Callable[..., Rig]) -> None:
    rig = at_slot()
    outcome = rig.run(Release(shelf="shelf_1"))
    assert isinstance(outcome, Fail)
    assert outcome.reason == "no board is below the book"
    assert rig.scene.held.rest is Rest.HAND


@pytest.mark.slow
def test_a_book_that_does_not_go_home_is_for_a_person(
    inserted: Callable[..., Rig], monkeypatch: pytest.MonkeyPatch
) -> None:
    rig = inserted()
    monkeypatch.setattr("handcart.backends.simulation.books.row_rule.PUSH_FRICTION", 40.0)
    outcome = rig.run(Release(shelf="shelf_1"))
    assert isinstance(outcome, GiveUp)
    assert "can't be pushed home" in outcome.reason
    assert np.allclose(rig.robot.arm.command(), rig.robot.spec.posture("home"))


@pytest.mark.slow
def test_fingers_that_pass_the_book_by_have_not_pushed_it_home(inserted: Callable[..., Rig]) -> None:
    rig = inserted()
    rig.model.of(Books).slot = None
    release = Release(shelf="shelf_1")
    aside = rig.scene.of(BookProps).shelves["shelf_1"].pose[:3, 1]

    def let_go() -> bool:
        book = rig.scene.of(BookProps).books[117]
        if book.rest is Rest.TABLE and not moved:
            book.pose = book.pose.copy()
            book.pose[:3, 3] += 0.5 * aside
            rig.scene.changes += 1
            moved.append(book)
        return False

    moved: list[Any] = []
    outcome = rig.run(release, let_go)
    assert isinstance(outcome, GiveUp)
    assert "the fingers don't meet the book" in outcome.reason


@pytest.mark.parametrize(("at", "stands"), [(0.105, True), (0.12, False), (-0.2, False)])
def test_the_label_has_to_be_read_where_the_book_was_let_go(at: float, stands: bool) -> None:
    """Another copy may be elsewhere on the shelf."""
    book = Book(
        accession=1, call="512.7 NAG", title="", shelf="s", thickness_mm=25, height_mm=210, depth_mm=150
    )
    model: Any = SimpleNamespace(of=lambda _: SimpleNamespace(book=book, slot=None))
    release = Release(shelf="shelf_1")
    release._lateral = 0.1
    label = Label("512.7 NAG", parse("512.7 NAG"), 0.9, np.zeros((4, 2)), at, 0.05)
    assert release._stands([label], model) is stands
