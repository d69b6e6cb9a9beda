"""How books and shelves look to a camera without physics."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache, partial

import cv2
import numpy as np
from numpy.typing import NDArray

from handcart.backends.simulation.rendering.canvas import Canvas
from handcart.backends.simulation.rendering.painting import CORNERS, NORMALS, Painted, paint_box
from handcart.backends.simulation.world.thing import GreyImage, Rest
from handcart.robotics.geometry.transform import transform
from handcart.robotics.kinematics.shapes import Box

from .book import Book
from .books_there import BooksThere
from .shelf import DEPTH, WOOD, Shelf
from .spec import BookSpec
from .textures import PX_PER_MM, draw_spine

_INSIDE, _DEPTH_DARK, _BOARD = 14, 18, 60
_PAGES, _METAL = 200, 90
_SEES = 3.0  # shelves further away are painted without their books [m]


def painted(books: BooksThere, rests: frozenset[Rest]) -> Iterator[Painted]:
    """Shelves with their rows, each at once; else single books. Fallen ones are not shown.

    Spines are printed; what stands deep in a shelf is dark.
    """
    if Rest.TABLE in rests:
        for shelf in books.shelves.values():
            yield Painted(shelf.pose[:3, 3], partial(_shelf, books=books, shelf=shelf))
    for book in books.books.values():
        inside = book.rest is Rest.HAND and any(_reaches_in(book, each) for each in books.shelves.values())
        if book.rest in rests & {Rest.TRAY, Rest.HAND} and not inside:
            yield Painted(book.box().pose[:3, 3], partial(_book, book=book, shelf=None))


def _shelf(canvas: Canvas, books: BooksThere, shelf: Shelf) -> None:
    parts = shelf.parts()
    eye = shelf.inverse_pose[:3, :3] @ canvas.eye + shelf.inverse_pose[:3, 3]
    if eye[0] >= 0.0 or np.linalg.norm(eye) > _SEES:
        for part in ("plinth", "board", "left panel", "right panel", "back"):
            paint_box(canvas, parts[part], WOOD)
        return
    _inside(canvas, shelf)
    ends = [parts["book end"]] if "book end" in parts else []
    bodies: list[tuple[float, Book | Box]] = [
        (_to_row(each.lateral, each.book.thickness, eye[1]), each.book)
        for each in books.shelf_books(shelf.name)
    ]
    bodies += [
        (_to_row((shelf.book_end_left - shelf.half_width) / 2, box.size[1], eye[1]), box) for box in ends
    ]
    held = _held_inside(books, shelf)
    if held is not None:
        lateral = float((shelf.inverse_pose @ held.pose)[1, 3])
        bodies.append((_to_row(lateral, held.thickness, eye[1]), held))
    # Between parallel bodies side by side the one further to the side never hides the nearer one.
    for _, body in sorted(bodies, key=lambda each: -each[0]):
        if isinstance(body, Book):
            _book(canvas, body, shelf)
        else:
            paint_box(canvas, body, _METAL)
    # Faces that look into the shelf are painted already, and books stand before them.
    for part, faces in (("plinth", (0,)), ("left panel", (0, 3, 5)), ("right panel", (0, 2, 5))):
        paint_box(canvas, parts[part], WOOD, faces)
    _board_edge(canvas, shelf)


def _to_row(lateral: float, thickness: float, eye: float) -> float:
    return max(0.0, abs(lateral - eye) - thickness / 2)


def _held_inside(books: BooksThere, shelf: Shelf) -> Book | None:
    """The held book, if it reaches into the shelf: its neighbours may hide it."""
    held = books.scene.held
    return held if isinstance(held, Book) and _reaches_in(held, shelf) else None


def _reaches_in(book: Book, shelf: Shelf) -> bool:
    fore = shelf.inverse_pose @ book.pose @ np.array([book.depth, 0.0, 0.0, 1.0])
    return bool(0.0 < fore[0] < DEPTH and abs(fore[1]) < shelf.half_width and -0.1 < fore[2] < 0.3)


def _inside(canvas: Canvas, shelf: Shelf) -> None:
    half, top = shelf.half_width, 0.35
    walls = (
        (((DEPTH, -half, 0), (DEPTH, half, 0), (DEPTH, half, top), (DEPTH, -half, top)), _INSIDE),
        (((0, half, 0), (DEPTH, half, 0), (DEPTH, half, top), (0, half, top)), _DEPTH_DARK),
        (((0, -half, 0), (DEPTH, -half, 0), (DEPTH, -half, top), (0, -half, top)), _DEPTH_DARK),
        (((0, -half, 0), (DEPTH, -half, 0), (DEPTH, half, 0), (0, half, 0)), _BOARD // 3),
        (((0, -half, 0), (0.01, -half, 0), (0.01, half, 0), (0, half, 0)), _BOARD),
    )
    for corners, grey in walls:
        canvas.polygon(_in_world(shelf, corners), grey)


def _board_edge(canvas: Canvas, shelf: Shelf) -> None:
    half = shelf.half_width
    corners = ((0, -half, -0.02), (0, half, -0.02), (0, half, 0), (0, -half, 0))
    canvas.polygon(_in_world(shelf, corners), WOOD + 20)


def _in_world(shelf: Shelf, corners: tuple[tuple[float, float, float], ...]) -> NDArray[np.float64]:
    return np.asarray(np.array(corners, dtype=float) @ shelf.pose[:3, :3].T + shelf.pose[:3, 3])


def _book(canvas: Canvas, book: Book, shelf: Shelf | None) -> None:
    """Covers and head, dark where they stand inside a shelf, then the spine."""
    front = 0.0 if shelf is None else float(np.clip(-(shelf.inverse_pose @ book.pose)[0, 3], 0.0, book.depth))
    lit_depth = book.depth if shelf is None else front
    cover = round(book.spec.grey * 0.75)
    if shelf is not None:
        _part(canvas, book, (lit_depth, book.depth), _DEPTH_DARK, _PAGES // 3)
    if lit_depth > 1e-4:
        _part(canvas, book, (0.0, lit_depth), cover, _PAGES)
    if canvas.seen_from_front(book.pose[:3, 3], -book.pose[:3, 0]):
        upper_left = transform((0.0, book.thickness / 2, book.height))
        face = book.pose @ upper_left @ _SPINE_FACE
        canvas.texture(spine_levels(book.spec), face)


# A spine's picture: x to the right is -y of the book, y downwards is -z.
_SPINE_FACE = np.array(
    [[0.0, 0.0, 1.0, 0.0], [-1.0, 0.0, 0.0, 0.0], [0.0, -1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]]
)


def _part(canvas: Canvas, book: Book, span: tuple[float, float], cover: int, head: int) -> None:
    middle = book.pose @ transform(((span[0] + span[1]) / 2, 0.0, book.height / 2))
    size = np.array([span[1] - span[0], book.thickness, book.height])
    normals = NORMALS @ middle[:3, :3].T
    corners = (CORNERS * size) @ middle[:3, :3].T + middle[:3, 3]
    for i, grey in ((1, head), (2, cover), (3, cover), (4, cover), (5, head), (0, cover)):
        if canvas.seen_from_front(corners[i][0], normals[i]):
            canvas.polygon(corners[i], grey)


@lru_cache(maxsize=512)
def spine_levels(spec: BookSpec) -> list[tuple[GreyImage, float]]:
    """A book's spine in falling resolution, each with its metres a pixel."""
    shown = None if spec.tag == "none" else spec.accession
    picture = draw_spine(
        spec.thickness_mm,
        spec.height_mm,
        spec.grey,
        tag_id=shown,
        call_number=spec.call,
        font=spec.font if spec.font.endswith(".ttf") else f"{spec.font}.ttf",
        smear=spec.tag == "smeared",
        seed=spec.accession,
        family=spec.tags,
    )
    levels = [(picture, 1e-3 / PX_PER_MM)]
    for _ in range(3):
        last, metres = levels[-1]
        # Cut to whole pairs, or the halved picture would be stretched.
        even = last[: last.shape[0] // 2 * 2, : last.shape[1] // 2 * 2]
        size = (even.shape[1] // 2, even.shape[0] // 2)
        levels.append((cv2.resize(even, size, interpolation=cv2.INTER_AREA).astype(np.uint8), 2 * metres))
    return levels
