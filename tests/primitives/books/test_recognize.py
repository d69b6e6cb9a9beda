"""RECOGNIZE at its public face, on the kinematic backend."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Literal

import numpy as np
import pytest

from handcart.backends.simulation.books.book_props import BookProps
from handcart.primitives.books.books import Books
from handcart.primitives.books.catalogue import Book, Catalogue
from handcart.primitives.books.recognize import Recognize
from handcart.primitives.outcomes.outcome import Fail, Success
from handcart.robotics.perception.landmarks.tag_reader import Tag, read_tags
from tests.primitives.conftest import Rig

TRAY = "tray: {{accession: 117, call: 512.7 NAG, thickness_mm: 25, height_mm: {}, depth_mm: 150, tag: {}}}\n"
NAGEL = Book(
    accession=117,
    call="512.7 NAG",
    title="",
    shelf="shelf_1",
    thickness_mm=25,
    height_mm=210,
    depth_mm=150,
)


@pytest.fixture
def with_tray(make_rig: Callable[..., Rig]) -> Callable[..., Rig]:
    def make(tray: str, seed: int = 0, books: tuple[Book, ...] = (NAGEL,)) -> Rig:
        rig = make_rig(tray, seed=seed)
        rig.model.of(Books).catalogue = Catalogue(format="handcart-catalogue/1", books=books)
        return rig

    return make


@pytest.mark.parametrize(("seed", "height"), [(0, 180), (1, 210), (2, 240), (3, 210)])
def test_it_tells_the_book_and_where_it_stands(with_tray: Callable[..., Rig], seed: int, height: int) -> None:
    rig = with_tray(TRAY.format(height, "readable"), seed)
    primitive = Recognize()
    assert isinstance(rig.run(primitive), Success)
    assert rig.model.of(Books).book == NAGEL
    truth = rig.scene.of(BookProps).tray_book().base_T_thing[:3, 3]
    pose = rig.model.of(Books).book_pose
    assert pose is not None
    assert math.dist(pose[:2], truth[:2]) < 0.002
    assert primitive.facts["call"] == "512.7 NAG"
    assert primitive.evidence.pictures["tray"].shape == (480, 640, 3)
    assert rig.scene.contacts == []


@pytest.mark.parametrize("tray", [TRAY.format(210, "smeared"), TRAY.format(210, "none"), ""])
def test_without_a_tag_it_is_a_fail_and_the_arm_back(with_tray: Callable[..., Rig], tray: str) -> None:
    rig = with_tray(tray)
    before = rig.robot.arm.command()
    outcome = rig.run(Recognize())
    assert isinstance(outcome, Fail)
    assert outcome.reason == "no tag can be read on the tray"
    assert not outcome.permanent
    assert np.array_equal(rig.robot.arm.command(), before)
    assert rig.model.of(Books).book is None


def test_a_book_that_the_library_does_not_own_is_a_fail_for_good(with_tray: Callable[..., Rig]) -> None:
    rig = with_tray(TRAY.format(210, "readable"), books=())
    outcome = rig.run(Recognize())
    assert isinstance(outcome, Fail)
    assert outcome.reason == "the book with the tag 117 is not in the catalogue"
    assert outcome.permanent
    assert rig.model.of(Books).book is None


@pytest.mark.parametrize("read_as", ["apriltag_36h11", "6x6_250"])
def test_tags_of_another_family(
    with_tray: Callable[..., Rig], read_as: Literal["apriltag_36h11", "6x6_250"]
) -> None:
    """A tag is read only as a tag of its own family."""
    rig = with_tray(TRAY.format(210, "readable, tags: apriltag_36h11"))
    rig.model.of(Books).catalogue = Catalogue(format="handcart-catalogue/1", tags=read_as, books=(NAGEL,))
    outcome = rig.run(Recognize())
    if read_as == "apriltag_36h11":
        assert isinstance(outcome, Success)
        assert rig.model.of(Books).book == NAGEL
    else:
        assert isinstance(outcome, Fail)
        assert "no tag can be read" in outcome.reason


def test_a_number_beyond_its_family_is_told() -> None:
    with pytest.raises(ValueError, match="the family 4x4_50 has no tag 117; allowed: below 50"):
        Catalogue(format="handcart-catalogue/1", tags="4x4_50", books=(NAGEL,))


def test_two_books_with_one_tag_are_refused() -> None:
    with pytest.raises(
        ValueError, match="several books have the tag 117; allowed: a tag of its own for each"
    ):
        Catalogue(format="handcart-catalogue/1", books=(NAGEL, NAGEL.model_copy(update={"call": "1 A"})))


def test_two_books_on_the_tray_are_told(
    with_tray: Callable[..., Rig], monkeypatch: pytest.MonkeyPatch
) -> None:
    def two(*args: Any, **more: Any) -> list[Tag]:
        seen = read_tags(*args, **more)
        return [*seen, *(Tag(118, tag.corners + np.array([30.0, 0.0])) for tag in seen)]

    monkeypatch.setattr("handcart.primitives.books.recognize.read_tags", two)
    rig = with_tray(TRAY.format(210, "readable"))
    outcome = rig.run(Recognize())
    assert isinstance(outcome, Fail)
    assert outcome.reason == "there are several tags on the tray: 117, 118"
    assert rig.model.of(Books).book is None
