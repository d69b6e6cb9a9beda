from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from handcart.robotics.perception.books.call_number import parse
from handcart.robotics.perception.books.gap_finder import GapFound, find_gap
from handcart.robotics.perception.books.label_reader import Label
from handcart.robotics.perception.books.ocr_label_reader import OcrLabelReader
from handcart.robotics.perception.books.shelf_views import fuse_labels, fuse_views
from handcart.robotics.perception.books.slots import find_slots
from handcart.robotics.perception.books.spine_edges import Strips
from handcart.robotics.perception.books.spines import Spine, SpineView, find_spines
from handcart.robotics.perception.drawing.overlay import draw_overlay

from ..conftest import Book, Bookshelf

TEXTS = [f"51{i}.{3 * i + 1} {c}AB" for i, c in enumerate("KLMNPRST")]


def _label(text: str, confidence: float = 0.9) -> Label:
    return Label(text, parse(text), confidence, np.zeros((4, 2)), 0.0, 0.035)


def _view(spine: Spine) -> SpineView:
    nothing = Strips(np.zeros((2, 2)), np.zeros(2), 0.1, 0.1, -1)
    return SpineView((spine,), (), nothing, 0.0, 0.1, -0.1)


@pytest.fixture(scope="module")
def reader() -> OcrLabelReader:
    return OcrLabelReader()


def _look(
    bookshelf: Bookshelf,
    reader: OcrLabelReader,
    books: list[Book],
    y: float,
    seed: int,
    pose_error: float = 0.0,
    mask: Any = None,
) -> tuple[SpineView, Any, list[Label], Any]:
    true = bookshelf.looking_from(y, rpy=(0.015, -0.01, 0.0))
    image = bookshelf.render(books, true, seed)
    believed = bookshelf.looking_from(y + pose_error, rpy=(0.0, 0.0, 0.0))
    labels = reader.read(image, bookshelf.camera, believed, mask)
    return find_spines(image, bookshelf.camera, believed, labels, mask), image, labels, believed


@pytest.mark.slow
def test_sides_of_spines_and_gaps_to_less_than_a_millimetre(
    bookshelf: Bookshelf, reader: OcrLabelReader
) -> None:
    books = bookshelf.row_of_books(TEXTS, 11, gaps={3: 0.032}, left=0.11)
    books = [book._replace(proud=0.0) for book in books]
    camera_T_shelf = bookshelf.looking_from(0.0, rpy=(0.02, 0.0, 0.0))
    image = bookshelf.render(books, camera_T_shelf, 11)
    labels = reader.read(image, bookshelf.camera, camera_T_shelf)
    view = find_spines(image, bookshelf.camera, camera_T_shelf, labels)
    assert len(view.spines) >= 4
    for spine in view.spines:
        book = min(books, key=lambda b: abs(b.left + b.right - spine.left - spine.right))
        assert spine.label is not None
        assert str(spine.label.call_number) == book.text
        assert (spine.left, spine.right) == pytest.approx((book.left, book.right), abs=0.0008)
    slot = next(interval for interval in fuse_views([view]).intervals if interval.width > 0.02)
    assert tuple(slot) == pytest.approx((books[2].right, books[3].left), abs=0.0008)


def test_a_held_book_hides_spines_but_makes_no_interval(bookshelf: Bookshelf, reader: OcrLabelReader) -> None:
    books = bookshelf.row_of_books(TEXTS, 12, left=0.11)
    mask = np.ones((480, 640), dtype=bool)
    mask[60:, 430:] = False
    camera_T_shelf = bookshelf.looking_from(0.0)
    image = bookshelf.render(books, camera_T_shelf, 12)
    image[~mask] = 12
    labels = reader.read(image, bookshelf.camera, camera_T_shelf, mask)
    view = find_spines(image, bookshelf.camera, camera_T_shelf, labels, mask)
    assert view.spines
    assert fuse_views([view]).intervals == ()


@pytest.mark.slow
def test_views_with_wrong_poses_are_aligned_by_their_books(
    bookshelf: Bookshelf, reader: OcrLabelReader
) -> None:
    books = bookshelf.row_of_books(TEXTS, 13, gaps={2: 0.03, 5: 0.036}, left=0.14)
    errors = (0.004, -0.003, 0.002, -0.003)
    places = (0.07, 0.02, -0.03, -0.08)
    views = [
        _look(bookshelf, reader, books, y, i, e)[0]
        for i, (y, e) in enumerate(zip(places, errors, strict=True))
    ]
    reading = fuse_views(views)
    numbers = [str(book.call_number) for book in reading.books]
    assert numbers == [text for text in TEXTS if text in numbers] and len(numbers) >= 6
    shifts = [
        book.left - next(b.left for b in books if b.text == str(book.call_number)) for book in reading.books
    ]
    assert np.ptp(shifts) < 0.0025
    solid = [(book.left, book.right) for book in reading.books]
    slots = [
        slot for interval in reading.intervals for slot in find_slots(views, reading.offsets, interval, solid)
    ]
    assert [slot.width for slot in slots] == pytest.approx([0.03, 0.036], abs=0.0015)
    wanted = parse("511.5 AAA")
    assert wanted is not None
    found = find_gap(reading._replace(gaps=tuple(slots)), wanted, 0.024)
    assert isinstance(found, GapFound)
    assert (str(found.before), str(found.after)) == (TEXTS[1], TEXTS[2])


def test_fusing_outvotes_a_wrong_reading() -> None:
    labels = [_label("512.7 NAG"), _label("512.7 NAC", 0.6), _label("512.7 NAG", 0.8)]
    assert fuse_labels(labels)[0] == parse("512.7 NAG")
    assert fuse_labels([_label("512.7 NAG"), _label("512.7 NAC")])[0] is None
    assert fuse_labels([_label("")]) == (None, 0.0)


def test_without_fusing_the_first_view_counts() -> None:
    first = _view(Spine(0.05, 0.02, _label("512.7 NAC", 0.6)))
    more = _view(Spine(0.052, 0.022, _label("512.7 NAG")))
    raw = fuse_views([first, more, more], fuse=False)
    assert [str(book.call_number) for book in raw.books] == ["512.7 NAC"]
    assert raw.books[0].left == pytest.approx(0.05)
    assert [str(book.call_number) for book in fuse_views([first, more, more]).books] == ["512.7 NAG"]


def test_no_views_show_no_books() -> None:
    assert fuse_views([]).books == ()
    assert fuse_views([]).intervals == ()


def test_overlay_is_a_coloured_copy(bookshelf: Bookshelf, reader: OcrLabelReader) -> None:
    books = bookshelf.row_of_books(TEXTS, 14, gaps={3: 0.03})
    view, image, labels, camera_T_shelf = _look(bookshelf, reader, books, 0.0, 14)
    before = image.copy()
    picture = draw_overlay(image, (), labels, view.spines, (), bookshelf.camera, camera_T_shelf)
    assert picture.shape == (480, 640, 3) and picture.dtype == np.uint8
    assert (picture[..., 0] != picture[..., 2]).mean() > 0.01
    assert np.array_equal(image, before)
