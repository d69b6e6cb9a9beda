from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest

from handcart.backends.simulation.books.textures import PX_PER_MM, draw_label
from handcart.robotics.perception.books.call_number import CallNumber, parse
from handcart.robotics.perception.books.ocr_label_reader import OcrLabelReader
from handcart.robotics.perception.books.template_label_reader import TemplateLabelReader

from ..conftest import Bookshelf

FONTS = ("DejaVuSans.ttf", "DejaVuSerif.ttf", "DejaVuSansMono-Bold.ttf", "STIXGeneral.ttf", "cmr10.ttf")
TEXTS = ["512.7 NAG", "513 OQD", "514.15 WIL", "515.082 BSB", "516.9 JIM", "517.61 VUY", "518.4 CGO"]


@pytest.fixture(scope="module")
def ocr() -> OcrLabelReader:
    return OcrLabelReader()


def _number(text: str) -> CallNumber:
    number = parse(text)
    assert number is not None
    return number


def _view(
    bookshelf: Bookshelf, seed: int, font: str, y: float = -0.01, texts: Sequence[str] = TEXTS
) -> tuple[Any, Any, list[tuple[CallNumber, float]]]:
    books = bookshelf.row_of_books(texts, seed, (font,), left=0.1)
    camera_T_shelf = bookshelf.looking_from(y, rpy=(0.02, -0.02, 0.03))
    inside = []
    for book in books:
        middle = (book.left + book.right) / 2
        ends = np.array([[middle + 0.007, 0.03], [middle - 0.007, 0.03]])
        columns = bookshelf.camera.plane_in_image(ends, camera_T_shelf, book.proud)[:, 0]
        if columns.min() > 6 and columns.max() < 633:
            assert book.text is not None
            inside.append((_number(book.text), middle))
    return bookshelf.render(books, camera_T_shelf, seed), camera_T_shelf, inside


@pytest.mark.slow
@pytest.mark.parametrize("seed, font", list(enumerate(FONTS)))
def test_every_label_in_view_is_read(bookshelf: Bookshelf, ocr: OcrLabelReader, seed: int, font: str) -> None:
    image, camera_T_shelf, inside = _view(bookshelf, seed, font)
    labels = ocr.read(image, bookshelf.camera, camera_T_shelf)
    read = {label.call_number: label for label in labels}
    assert len(inside) >= 4
    for number, lateral in inside:
        assert read[number].lateral == pytest.approx(lateral, abs=0.0015)
        assert read[number].confidence > 0.9


@pytest.mark.slow
def test_reading_is_the_same_every_time(bookshelf: Bookshelf, ocr: OcrLabelReader) -> None:
    image, camera_T_shelf, _ = _view(bookshelf, 9, FONTS[1])
    first = ocr.read(image, bookshelf.camera, camera_T_shelf)
    again = OcrLabelReader().read(image, bookshelf.camera, camera_T_shelf)
    assert [(a.text, a.confidence) for a in first] == [(b.text, b.confidence) for b in again]


def test_a_catalogue_makes_readings_known_ones(bookshelf: Bookshelf) -> None:
    image, camera_T_shelf, inside = _view(bookshelf, 1, FONTS[0])
    catalogue = [_number(text) for text in TEXTS[1:]]
    labels = OcrLabelReader(catalogue).read(image, bookshelf.camera, camera_T_shelf)
    numbers = [label.call_number for label in labels]
    assert parse(TEXTS[0]) not in numbers
    assert [n for n in numbers if n is not None] == [n for n, _ in inside if n in catalogue]


def test_as_many_letters_are_read_as_the_catalogue_has(bookshelf: Bookshelf) -> None:
    texts = ["512.7 N", "513 NA", "514.15 WILD", "515.08265 BSB", "516.9 JI", "517.61 VU", "518.4 CGOM"]
    image, camera_T_shelf, inside = _view(bookshelf, 1, FONTS[0], texts=texts)
    labels = OcrLabelReader([_number(text) for text in texts]).read(image, bookshelf.camera, camera_T_shelf)
    read = {label.text for label in labels if label.confidence > 0.8}
    assert len(inside) >= 4
    assert {str(number) for number, _ in inside} - read == set()


def test_what_a_held_book_covers_is_not_read(bookshelf: Bookshelf, ocr: OcrLabelReader) -> None:
    image, camera_T_shelf, inside = _view(bookshelf, 2, FONTS[0])
    mask = np.ones(image.shape, dtype=bool)
    mask[:, 400:] = False
    labels = ocr.read(image, bookshelf.camera, camera_T_shelf, mask)
    assert 0 < len(labels) < len(inside)
    assert all(label.corners[:, 0].max() < 402 for label in labels)


def test_shelf_without_labels_has_none(bookshelf: Bookshelf, ocr: OcrLabelReader) -> None:
    """Titles on bright covers are not labels."""
    books = bookshelf.row_of_books([None] * 7, 3)
    books[3] = books[3]._replace(grey=230)
    camera_T_shelf = bookshelf.looking_from(0.0)
    assert ocr.read(bookshelf.render(books, camera_T_shelf, 3), bookshelf.camera, camera_T_shelf) == []


@pytest.mark.parametrize("grey", [5, 215, 240])
def test_labels_are_read_on_covers_from_black_to_white(
    bookshelf: Bookshelf, ocr: OcrLabelReader, grey: int
) -> None:
    books = [book._replace(grey=grey) for book in bookshelf.row_of_books(TEXTS[:4], 3, left=0.07)]
    camera_T_shelf = bookshelf.looking_from(0.0)
    labels = ocr.read(bookshelf.render(books, camera_T_shelf, 3), bookshelf.camera, camera_T_shelf)
    assert [label.text for label in labels] == list(TEXTS[:4])


def test_a_camera_that_looks_away_is_an_error(bookshelf: Bookshelf, ocr: OcrLabelReader) -> None:
    image = np.zeros((480, 640), dtype=np.uint8)
    with pytest.raises(ValueError, match="look at the shelf"):
        ocr.read(image, bookshelf.camera, bookshelf.looking_from(0.0, rpy=(0, 0, 1.5)))


def test_templates_find_the_known_labels(bookshelf: Bookshelf) -> None:
    font = FONTS[1]
    known = [*TEXTS, *(f"{600 + i}.{i} ABC" for i in range(40))]
    templates = {_number(t): np.rot90(draw_label(t, font)).astype(np.uint8).copy() for t in known}
    reader = TemplateLabelReader(templates, PX_PER_MM * 1000)
    image, camera_T_shelf, inside = _view(bookshelf, 4, font)
    numbers = [label.call_number for label in reader.read(image, bookshelf.camera, camera_T_shelf)]
    assert [n for n in numbers if n is not None] == [number for number, _ in inside]
