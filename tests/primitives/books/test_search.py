"""SEARCH at its public face, on the kinematic backend."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Literal

import numpy as np
import pytest

from handcart.backends.simulation.books.book_props import BookProps
from handcart.backends.simulation.books.standing_book import leaned
from handcart.primitives.books.book_causes import NO_SLOT
from handcart.primitives.books.books import Books
from handcart.primitives.books.catalogue import Book, Catalogue
from handcart.primitives.books.search import Search, _end_of_row
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.outcome import Fail, Success
from handcart.robotics.perception.books.call_number import parse
from handcart.robotics.perception.books.ocr_label_reader import OcrLabelReader
from handcart.robotics.perception.books.shelf_views import ShelfBook, ShelfReading
from tests.primitives.conftest import Rig


@pytest.fixture
def docked(at_slot: Callable[..., Rig]) -> Callable[..., Rig]:
    """Builds a rig before the shelf, the book in the hand, no slot known, all books in the catalogue."""

    def make(seed: int = 0, call: str = "512.7 NAG", shelf: str = "") -> Rig:
        rig = at_slot(seed=seed, shelf=shelf)
        known = rig.model.of(Books)
        known.slot = None
        assert known.book is not None
        known.book = known.book.model_copy(update={"call": call})
        specs = [book.book.spec for book in rig.scene.of(BookProps).shelf_books("shelf_1")]
        books = [
            Book(
                accession=spec.accession,
                call=spec.call,
                title="",
                shelf="shelf_1",
                thickness_mm=spec.thickness_mm,
                height_mm=spec.height_mm,
                depth_mm=spec.depth_mm,
            )
            for spec in specs
        ]
        known.catalogue = Catalogue(format="handcart-catalogue/1", books=(*books, known.book))
        return rig

    return make


def row(rig: Rig) -> list[tuple[float, float]]:
    """Left and right of each book in the shelf frame, in [m]."""
    return [
        (book.lateral + book.book.thickness / 2, book.lateral - book.book.thickness / 2)
        for book in rig.scene.of(BookProps).shelf_books("shelf_1")
    ]


@pytest.mark.slow
@pytest.mark.parametrize(("seed", "reader"), [(0, "ocr"), (1, "ocr"), (2, "template")])
def test_it_finds_the_slot_between_the_right_neighbours(
    docked: Callable[..., Rig], seed: int, reader: Literal["ocr", "template"]
) -> None:
    rig = docked(seed)
    primitive = Search(shelf="shelf_1", reader=reader)
    assert isinstance(rig.run(primitive), Success)
    slot = rig.model.of(Books).slot
    assert slot is not None
    assert (slot.shelf, slot.after, slot.before) == ("shelf_1", "510.7 ABE", "512.8 ABE")
    left, right = row(rig)[7][1], row(rig)[8][0]
    assert slot.left - slot.right == pytest.approx(left - right, abs=0.0015)
    assert slot.left == pytest.approx(left, abs=0.02)  # along the shelf the map counts
    assert primitive.facts["labels_read"] == 10
    views = primitive.facts["views"]
    assert not isinstance(views, str)
    assert len(primitive.evidence.pictures) == views <= 10
    assert rig.scene.contacts == []


@pytest.mark.slow
def test_at_the_end_of_the_row_it_looks_straight_at_the_book_end(docked: Callable[..., Rig]) -> None:
    rig = docked(0, call="512.9 ZUS")
    aside = rig.scene.of(BookProps).shelves["shelf_1"].pose[:3, 1]
    rig.scene.of(BookProps).books[20].pose[:3, 3] -= 0.009 * aside
    del rig.scene.of(BookProps).books[21]
    rig.scene.changes += 1
    assert isinstance(rig.run(Search(shelf="shelf_1")), Success)
    slot = rig.model.of(Books).slot
    assert slot is not None
    assert (slot.after, slot.before) == ("512.8 ABE", "")
    assert slot.left - slot.right == pytest.approx(0.031, abs=0.0025)


@pytest.mark.slow
def test_where_no_slot_is_free_it_is_a_fail_for_good_and_the_arm_back(docked: Callable[..., Rig]) -> None:
    rig = docked(0, call="510.35 ZUS")
    before = rig.robot.arm.command()
    outcome = rig.run(Search(shelf="shelf_1"))
    assert isinstance(outcome, Fail)
    assert outcome.reason == "510.35 ZUS belongs between 510.3 ABE and 510.4 ABE, and there is no free slot"
    assert outcome.permanent and outcome.cause is NO_SLOT
    assert np.array_equal(rig.robot.arm.command(), before)
    assert rig.model.of(Books).slot is None


@pytest.mark.slow
def test_where_no_label_is_read_the_slot_is_not_seen(
    docked: Callable[..., Rig], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The cause indicates that another look may help."""
    rig = docked(0)
    monkeypatch.setattr(OcrLabelReader, "read", lambda *_: [])
    outcome = rig.run(Search(shelf="shelf_1"))
    assert isinstance(outcome, Fail)
    assert (outcome.reason, outcome.cause) == ("no call number could be read on the shelf", causes.NOT_SEEN)


def in_slot(front_mm: float, grey: int = 120) -> str:
    """A thing of 28 mm in the slot of 31 mm, so far behind the shelf's front."""
    thing = f"{{at_mm: 321, width_mm: 28, height_mm: 180, front_mm: {front_mm}, grey: {grey}}}"
    return f"    objects: [{thing}]\n"


@pytest.mark.slow
@pytest.mark.parametrize("light", [0.0, 1.0])
def test_darkness_tells_no_slot(docked: Callable[..., Rig], light: float) -> None:
    rig = docked(3, shelf=f"    light: {light}\n")
    assert isinstance(rig.run(Search(shelf="shelf_1")), Success)
    slot = rig.model.of(Books).slot
    assert slot is not None
    left, right = row(rig)[7][1], row(rig)[8][0]
    assert slot.left - slot.right == pytest.approx(left - right, abs=0.002)


ABOVE = """\
  - name: above
    x_m: 6.5
    y_m: 5.4
    heading_deg: 90
    board_m: 1.06
    closed_from_m: 1.05
    books:
      - {accession: 70, call: "512.6 ABE", thickness_mm: 40, height_mm: 210, depth_mm: 150}
      - {gap_mm: 31}
      - {accession: 71, call: "512.8 ABE", thickness_mm: 40, height_mm: 210, depth_mm: 150}
"""


@pytest.mark.slow
def test_another_row_above_is_not_this_one(docked: Callable[..., Rig]) -> None:
    """Its slot would be the right one by its labels."""
    rig = docked(0, shelf=ABOVE)
    primitive = Search(shelf="shelf_1")
    assert isinstance(rig.run(primitive), Success)
    slot = rig.model.of(Books).slot
    assert slot is not None
    assert (slot.after, slot.before) == ("510.7 ABE", "512.8 ABE")
    assert primitive.facts["labels_read"] == 10
    assert rig.scene.contacts == []


@pytest.mark.slow
@pytest.mark.parametrize("grey", [0, 120])
def test_what_stands_in_the_slot_as_far_forward_as_a_spine_is_no_slot(
    docked: Callable[..., Rig], grey: int
) -> None:
    """Black as an empty slot, or not."""
    rig = docked(0, shelf=in_slot(0.0, grey))
    outcome = rig.run(Search(shelf="shelf_1"))
    assert isinstance(outcome, Fail)
    assert outcome.permanent
    assert "there is no free slot" in outcome.reason


@pytest.mark.slow
def test_where_a_neighbour_leans_into_the_slot_is_a_fail(docked: Callable[..., Rig]) -> None:
    rig = docked(0)
    books = rig.scene.of(BookProps)
    neighbour = books.shelf_books("shelf_1")[7].book
    shelf = books.shelves["shelf_1"]
    neighbour.pose = shelf.pose @ leaned(shelf.inverse_pose @ neighbour.pose, neighbour.thickness, -0.14)
    rig.scene.changes += 1
    outcome = rig.run(Search(shelf="shelf_1"))
    assert isinstance(outcome, Fail)
    assert re.search(r"where it belongs the book 510.7 ?ABE leans by 8 degrees", outcome.reason), (
        outcome.reason
    )


def test_without_a_book_there_is_nothing_to_look_for(docked: Callable[..., Rig]) -> None:
    rig = docked()
    rig.model.of(Books).book = None
    outcome = rig.run(Search(shelf="shelf_1"))
    assert isinstance(outcome, Fail)
    assert outcome.reason == "no book has been recognized"


@pytest.mark.parametrize(("no_gap", "end"), [(False, None), (True, -0.12)])
def test_misplaced_last_book_hides_the_end_if_no_slot_precedes_it(no_gap: bool, end: float | None) -> None:
    calls = ("511.1 ABE", "513.1 ABE", "510.2 ABE")
    books = tuple(
        ShelfBook(-0.04 * at, -0.04 * (at + 1), parse(call), 0.9, 2) for at, call in enumerate(calls)
    )
    wanted, between = parse("515.1 ABE"), parse("512.1 ABE")
    assert wanted is not None
    assert between is not None
    reading = ShelfReading(books, (), ())
    assert _end_of_row(reading, wanted, no_gap) == (None if end is None else pytest.approx(end))
    assert _end_of_row(reading._replace(books=books[:2]), wanted, no_gap) == pytest.approx(-0.08)
    assert _end_of_row(reading, between, no_gap) is None
