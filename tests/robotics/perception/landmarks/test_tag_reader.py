from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from handcart.robotics.perception.landmarks.tag_family import (
    CORRECTING_FAMILIES,
    TagFamily,
    dictionary,
    modules_of,
)
from handcart.robotics.perception.landmarks.tag_reader import Region, read_tags, tag_pose

from ..conftest import Bookshelf

HEIGHT = 0.2
TAG_HEIGHT = HEIGHT - 0.014


def _scene(
    bookshelf: Bookshelf, distance: float, seed: int, smear: bool = False
) -> tuple[Any, Any, list[tuple[int, float]]]:
    books = bookshelf.row_of_books([None] * 6, seed)
    books = [b._replace(tag=37 * i + 5, height=HEIGHT, smear=smear, proud=0.0) for i, b in enumerate(books)]
    camera_T_shelf = bookshelf.looking_from(0.02, z=0.16, distance=distance, rpy=(0.03, -0.02, 0.03))
    visible = []
    for book in books:
        y = (book.left + book.right) / 2
        ends = np.array([[y + 0.009, TAG_HEIGHT], [y - 0.009, TAG_HEIGHT]])
        columns = bookshelf.camera.plane_in_image(ends, camera_T_shelf)[:, 0]
        if columns.min() > 2 and columns.max() < 637:
            assert book.tag is not None
            visible.append((book.tag, y))
    return bookshelf.render(books, camera_T_shelf, seed), camera_T_shelf, visible


@pytest.mark.parametrize("distance", [0.2, 0.25, 0.3, 0.34])
def test_all_small_tags_in_view_are_read(bookshelf: Bookshelf, distance: float) -> None:
    image, _, visible = _scene(bookshelf, distance, seed=3)
    assert len(visible) >= 3
    assert sorted(tag.id for tag in read_tags(image)) == sorted(number for number, _ in visible)


@pytest.mark.slow
def test_smeared_and_half_covered_tags_are_no_tags(bookshelf: Bookshelf) -> None:
    image, _, _ = _scene(bookshelf, 0.25, seed=4, smear=True)
    assert read_tags(image) == []
    image, _, _ = _scene(bookshelf, 0.25, seed=4)
    for tag in read_tags(image):
        middle = tag.corners.mean(axis=0).astype(int)
        image[middle[1] : middle[1] + 30, middle[0] - 30 : middle[0] + 30] = 90
    assert read_tags(image) == []


def test_a_region_gives_the_same_corners(bookshelf: Bookshelf) -> None:
    image, _, _ = _scene(bookshelf, 0.25, seed=5)
    tag = read_tags(image)[1]
    left, top = (tag.corners.min(axis=0) - 25).astype(int)
    inside = read_tags(image, Region(int(left), int(top), int(left) + 90, int(top) + 90))
    assert [found.id for found in inside] == [tag.id]
    assert inside[0].corners == pytest.approx(tag.corners, abs=0.2)


def test_a_region_outside_the_image_is_empty(bookshelf: Bookshelf) -> None:
    assert read_tags(np.zeros((480, 640), dtype=np.uint8), Region(700, 10, 800, 90)) == []


def test_pose_of_a_tag(bookshelf: Bookshelf) -> None:
    image, camera_T_shelf, visible = _scene(bookshelf, 0.22, seed=6)
    places = dict(visible)
    tags = read_tags(image)
    assert tags
    for tag in tags:
        pose = tag_pose(tag, bookshelf.camera, 0.010)
        true = camera_T_shelf @ np.array([0.0, places[tag.id], TAG_HEIGHT, 1.0])
        assert pose[:3, 3] == pytest.approx(true[:3], abs=0.006)
        assert np.linalg.norm(pose[:2, 3] - true[:2]) < 0.002


@pytest.mark.parametrize("region", [None, Region(40, 30, 220, 200)])
def test_corners_are_where_black_ends_by_the_centres_of_pixels(region: Region | None) -> None:
    """A whole number is a pixel's centre: a square from pixel 60 to 129 reaches from 59.5 to 129.5."""
    image = np.full((240, 320), 255, dtype=np.uint8)
    image[50:120, 60:130] = dictionary("5x5_250").generateImageMarker(7, 70)
    (tag,) = read_tags(image, region)
    assert tag.id == 7
    assert tag.corners.mean(axis=0) == pytest.approx([94.5, 84.5], abs=0.1)
    assert tag.corners[0] == pytest.approx([59.5, 49.5], abs=0.2)


def _damaged(family: TagFamily, number: int, bits: int, rng: np.random.Generator) -> Any:
    """A tag on white whose given number of bits is turned over."""
    inner = modules_of(family) - 2
    cells = dictionary(family).generateImageMarker(number, 10 * (inner + 2)).astype(np.uint8)
    for where in rng.choice(inner * inner, bits, replace=False).tolist():
        row, column = 10 * (1 + where // inner), 10 * (1 + where % inner)
        cells[row : row + 10, column : column + 10] ^= 255
    return np.pad(cells, 30, constant_values=255)


@pytest.mark.parametrize("family", ["5x5_250", "apriltag_16h5", *CORRECTING_FAMILIES])
def test_one_damaged_bit_is_corrected_where_codes_differ_enough(family: TagFamily) -> None:
    rng = np.random.default_rng(1)
    for number in range(8):
        for bits, wanted in ((0, [number]), (1, [number] if family in CORRECTING_FAMILIES else [])):
            assert [t.id for t in read_tags(_damaged(family, number, bits, rng), family=family)] == wanted
        for bits in (2, 3):
            assert read_tags(_damaged(family, number, bits, rng), family=family) == []
