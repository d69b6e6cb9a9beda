"""A book that is let go may lean, as far as its neighbours let it, and the judge sees it."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from handcart.backends.kinematic.kinematic_backend import KinematicBackend
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.simulation.books.book import SimulatedBook
from handcart.backends.simulation.books.book_lean import lean_in_row
from handcart.backends.simulation.books.book_props import BookProps
from handcart.backends.simulation.books.putting_down import put_down
from handcart.backends.simulation.books.row import Member
from handcart.backends.simulation.books.spec import BookSpec
from handcart.backends.simulation.world.thing import Rest
from handcart.backends.simulation.world.world_file import WorldFile
from handcart.evaluation.books.shelving import shelving
from handcart.robotics.geometry.transform import transform

from .conftest import Puppet

SPEC = BookSpec(accession=1, call="512.7 NAG", thickness_mm=25, height_mm=210, depth_mm=150)
BOOK = SimulatedBook(np.eye(4), Rest.HAND, SPEC)
TIPPING = math.atan2(0.025, 0.21)
FOOT = transform((0.0, 0.1, 0.0))


def row(left: float, right: float, top: float = 0.3) -> list[Member]:
    """Neighbours whose sides are that far from those of the book, in [m]."""
    near, far = 0.1 - 0.0125 - right, 0.1 + 0.0125 + left
    return [Member(near - 0.03, near, 0.0, top, None), Member(far, far + 0.03, 0.0, top, None)]


def lean(wish: float, beside: list[Member]) -> float | None:
    pose = lean_in_row(BOOK, FOOT, beside, wish)
    return None if pose is None else -math.atan2(pose[2, 1], pose[2, 2])


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_what_it_leans_depends_on_the_gap_beside(side: float) -> None:
    wide = row(0.06, 0.06)
    assert lean(side * 0.02, wide) == pytest.approx(side * 0.02)
    assert lean(side * 0.02, row(0.002, 0.002)) == pytest.approx(side * math.asin(0.002 / 0.21))
    over = TIPPING + 0.001
    assert lean(side * over, wide) == pytest.approx(side * math.asin(0.06 / 0.21))
    assert lean(side * over, row(0.06, 0.06, top=0.1)) == pytest.approx(side * math.atan2(0.06, 0.1))
    assert lean(side * over, row(0.25, 0.25)) is None


def test_leaning_book_edge_stays_on_the_board_and_top_touches() -> None:
    pose = lean_in_row(BOOK, FOOT, row(0.03, 0.03), TIPPING + 0.001)
    assert pose is not None
    corners = [pose @ np.array([0.0, y, z, 1.0]) for y in (-0.0125, 0.0125) for z in (0.0, 0.21)]
    assert min(corner[2] for corner in corners) == pytest.approx(0.0, abs=1e-9)
    assert max(corner[1] for corner in corners) == pytest.approx(0.1 + 0.0125 + 0.03, abs=1e-9)


def test_a_book_left_leaning_in_a_wide_gap_is_not_right(world: Any) -> None:
    """`tilt_deg` can fail: the same book stands in a gap that is too wide, and in one that isn't."""
    shelf = world.shelves[0]
    stood = {}
    for gap in (31, 90):
        books = [
            item.model_copy(update={"gap_mm": gap}) if hasattr(item, "gap_mm") else item
            for item in shelf.books
        ]
        wider = shelf.model_copy(update={"width_m": 0.5, "books": tuple(books)})
        robot = load_robot("librarian")
        backend: Any
        with KinematicBackend(robot, world.model_copy(update={"shelves": (wider,)}), 0) as backend:
            scene = backend.scene
            book, frame = scene.of(BookProps).books[117], scene.of(BookProps).shelves["shelf_1"]
            book.pose = frame.pose @ transform((0.0, 0.25 - 0.13 - gap / 2e3, 0.002))
            book.rest = Rest.HAND
            judged = shelving(scene.of(BookProps), (117,))
            put_down(scene.of(BookProps), book, None, aside=TIPPING + 0.01)
            stood[gap] = judged.judge(scene.of(BookProps))
    assert stood[31].tilt_deg == pytest.approx(math.degrees(math.asin(0.003 / 0.21)), abs=0.01)
    assert stood[31].right
    assert stood[90].tilt_deg > 5.0
    assert stood[90].slot_correct
    assert not stood[90].right


def test_released_by_the_hand_it_leans_by_the_robots_errors(puppet: Puppet) -> None:
    puppet.insert()
    puppet.fingers(0.07)
    (book,) = [
        shelf_book
        for shelf_book in puppet.scene.of(BookProps).shelf_books("shelf_1")
        if shelf_book.book.accession == 117
    ]
    assert 1e-5 < abs(book.lean) < 0.03
    right, left = book.sides
    assert left - right > 0.025


def test_without_errors_it_stands_upright(world: WorldFile) -> None:
    backend: Any
    with KinematicBackend(load_robot("librarian").without_errors(), world, 0) as backend:
        scene = backend.scene
        book = scene.of(BookProps).books[117]
        book.pose = scene.of(BookProps).shelves["shelf_1"].pose @ transform((0.0, 0.0545, 0.002))
        put_down(scene.of(BookProps), book, None)
        (stands,) = [
            shelf_book for shelf_book in scene.of(BookProps).shelf_books("shelf_1") if shelf_book.book is book
        ]
        assert stands.tilt == pytest.approx(0.0, abs=1e-9)
