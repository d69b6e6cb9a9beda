"""Appearance of books and shelves without physics."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import lru_cache, partial
from itertools import pairwise

import cv2
import numpy as np

from handcart.backends.simulation.world.canvas import Canvas
from handcart.backends.simulation.world.painting import SIDE_CORNERS, SIDE_NORMALS, Painted, paint_box
from handcart.backends.simulation.world.thing import Rest
from handcart.robotics.geometry.transform import transform
from handcart.robotics.kinematics.shapes import Box
from handcart.robotics.numerics.arrays import ByteArray, FloatArray

from .book import SimulatedBook
from .books_there import BooksThere
from .shelf import PANEL_HEIGHT_M, SHELF_DEPTH_M, WOOD_GREY, SimulatedShelf
from .spec import BookSpec
from .textures import PX_PER_MM, draw_spine

_BOARD, _PAGES, _METAL = 70, 200, 90
_COVER = 0.75  # of a cover's grey beside its spine's: light comes from before it
_DIMS = 0.03  # [m] into a shelf after which 1/e of the room's light is left
_BANDS = (
    0.0,
    0.004,
    0.01,
    0.02,
    0.035,
    0.06,
    0.1,
    SHELF_DEPTH_M,
)  # [m] into a shelf, each painted in one shade
_WINDOW = (-2.0, 1.2)  # x, y in S of what glossy spines mirror, in [m]
_BOW = 0.25  # [rad] by which a spine's sides are turned away from its middle
_STREAK, _STREAK_GREY = 0.12, 200.0  # width of a mirrored window as a share of the spine's; of full gloss
_SEES = 3.0  # shelves further away are painted without their books [m]


def painted(books: BooksThere, rests: frozenset[Rest]) -> Iterator[Painted]:
    """Yield the objects that a simulated camera shows: each shelf with its books, and books on the tray or in
    the hand.

    Fallen books are not shown. Spines are printed; objects deep in a shelf are dark.

    Args:
        books: books and shelves of the world.
        rests: kinds of support; only books that rest on one of these are shown.
    """
    if Rest.TABLE in rests:
        for shelf in books.shelves.values():
            yield Painted(shelf.outer_box(), partial(_shelf, books=books, shelf=shelf))
    for book in books.books.values():
        inside = book.rest is Rest.HAND and any(_reaches_in(book, spec) for spec in books.shelves.values())
        if book.rest in rests & {Rest.TRAY, Rest.HAND} and not inside:
            yield Painted(book.box(), partial(_book, book=book, shelf=None))


def _light(shelf: SimulatedShelf, depth: float) -> float:
    """Return the share of the room's light, 0 to 1, at a depth in [m] behind the board's front edge."""
    light = shelf.spec.light
    return light + (1.0 - light) * math.exp(-max(0.0, depth) / _DIMS)


def _shelf(canvas: Canvas, books: BooksThere, shelf: SimulatedShelf) -> None:
    parts = shelf.parts()
    eye = shelf.inverse_pose[:3, :3] @ canvas.eye + shelf.inverse_pose[:3, 3]
    if eye[0] >= 0.0 or np.linalg.norm(eye) > _SEES:
        for part in ("plinth", "board", "left panel", "right panel", "back"):
            paint_box(canvas, parts[part], WOOD_GREY)
        return
    _inside(canvas, shelf)
    bodies: list[tuple[float, SimulatedBook | tuple[Box, int]]] = [
        (_to_row(book.lateral, book.book.thickness, eye[1]), book.book)
        for book in books.shelf_books(shelf.name)
    ]
    greys = {part: object_.grey for part, object_ in zip(shelf.objects(), shelf.spec.objects, strict=True)}
    for part in parts.keys() & {"book end", *greys}:
        box = parts[part]
        middle = shelf.inverse_pose @ box.pose[:, 3]
        grey = greys.get(part, _METAL) * _light(shelf, float(middle[0]) - box.size[0] / 2)
        bodies.append((_to_row(float(middle[1]), box.size[1], eye[1]), (box, round(grey))))
    held = _held_inside(books, shelf)
    if held is not None:
        lateral = float((shelf.inverse_pose @ held.pose)[1, 3])
        bodies.append((_to_row(lateral, held.thickness, eye[1]), held))
    # Between parallel bodies side by side the one further to the side never hides the nearer one.
    for _, body in sorted(bodies, key=lambda pair: -pair[0]):
        if isinstance(body, SimulatedBook):
            _book(canvas, body, shelf)
        else:
            paint_box(canvas, *body)
    # Faces that look into the shelf are already painted, and books are in front of them.
    for part, faces in (("plinth", (0,)), ("left panel", (0, 3, 5)), ("right panel", (0, 2, 5))):
        paint_box(canvas, parts[part], WOOD_GREY, faces)
    _board_edge(canvas, shelf)


def _to_row(lateral: float, thickness: float, eye: float) -> float:
    return max(0.0, abs(lateral - eye) - thickness / 2)


def _held_inside(books: BooksThere, shelf: SimulatedShelf) -> SimulatedBook | None:
    """Return the held book, if it reaches into the shelf: its neighbours may hide it."""
    held = books.scene.held
    return held if isinstance(held, SimulatedBook) and _reaches_in(held, shelf) else None


def _reaches_in(book: SimulatedBook, shelf: SimulatedShelf) -> bool:
    fore = shelf.inverse_pose @ book.pose @ np.array([book.depth, 0.0, 0.0, 1.0])
    return bool(0.0 < fore[0] < SHELF_DEPTH_M and abs(fore[1]) < shelf.half_width and -0.1 < fore[2] < 0.3)


def _inside(canvas: Canvas, shelf: SimulatedShelf) -> None:
    half = shelf.half_width
    back = (
        (SHELF_DEPTH_M, -half, 0),
        (SHELF_DEPTH_M, half, 0),
        (SHELF_DEPTH_M, half, PANEL_HEIGHT_M),
        (SHELF_DEPTH_M, -half, PANEL_HEIGHT_M),
    )
    canvas.polygon(_in_world(shelf, back), round(WOOD_GREY * _light(shelf, SHELF_DEPTH_M)))
    for near, far in pairwise(_BANDS):
        light = _light(shelf, (near + far) / 2)
        for side in (half, -half):
            panel = (
                (near, side, 0),
                (far, side, 0),
                (far, side, PANEL_HEIGHT_M),
                (near, side, PANEL_HEIGHT_M),
            )
            canvas.polygon(_in_world(shelf, panel), round(_COVER * WOOD_GREY * light))
        board = ((near, -half, 0), (far, -half, 0), (far, half, 0), (near, half, 0))
        canvas.polygon(_in_world(shelf, board), round(_BOARD * light))


def _board_edge(canvas: Canvas, shelf: SimulatedShelf) -> None:
    half = shelf.half_width
    corners = ((0, -half, -0.02), (0, half, -0.02), (0, half, 0), (0, -half, 0))
    canvas.polygon(_in_world(shelf, corners), WOOD_GREY + 20)


def _in_world(shelf: SimulatedShelf, corners: tuple[tuple[float, float, float], ...]) -> FloatArray:
    return np.asarray(np.array(corners, dtype=float) @ shelf.pose[:3, :3].T + shelf.pose[:3, 3])


def _book(canvas: Canvas, book: SimulatedBook, shelf: SimulatedShelf | None) -> None:
    """Paint covers and head, darker with their depth inside a shelf, then the spine."""
    box = book.box()
    if canvas.shows_none((SIDE_CORNERS.reshape(-1, 3) * box.size) @ box.pose[:3, :3].T + box.pose[:3, 3]):
        return
    front = 0.0 if shelf is None else float((shelf.inverse_pose @ book.pose)[0, 3])
    if shelf is None:
        _part(canvas, book, (0.0, book.depth), 1.0)
    else:
        spans = [(max(0.0, near - front), min(book.depth, far - front)) for near, far in pairwise(_BANDS)]
        for near, far in [*spans[::-1], (0.0, min(book.depth, -front))]:
            if far - near > 1e-4:
                _part(canvas, book, (near, far), _light(shelf, front + (near + far) / 2))
    if canvas.seen_from_front(book.pose[:3, 3], -book.pose[:3, 0]):
        upper_left = transform((0.0, book.thickness / 2, book.height))
        face = book.pose @ upper_left @ _SPINE_FACE
        light = 1.0 if shelf is None else _light(shelf, front)
        streak = _mirrored(book, shelf, canvas.eye)
        shade = partial(_lit, light=light, streak=streak, gloss=book.spec.gloss)
        canvas.texture(spine_levels(book.spec), face, shade)


def _mirrored(book: SimulatedBook, shelf: SimulatedShelf | None, eye: FloatArray) -> float | None:
    """Return where a glossy spine mirrors a window to a camera, 0 to 1 from its left side; None if nowhere.

    Args:
        book: book on the shelf.
        shelf: shelf of the book; None: no window is mirrored.
        eye: (3,) position of the camera in the world, in [m].
    """
    if shelf is None or book.spec.gloss == 0.0:
        return None
    spine, eye_S = (shelf.inverse_pose @ book.pose)[:2, 3], shelf.inverse_pose[:2] @ np.append(eye, 1.0)
    angles = [math.atan2(y - spine[1], spine[0] - x) for x, y in (_WINDOW, eye_S)]
    bent = (angles[0] + angles[1]) / 2 / _BOW
    return 0.5 - 0.5 * bent if abs(bent) < 1.0 else None


def _lit(picture: ByteArray, light: float, streak: float | None, gloss: float) -> ByteArray:
    """Return a spine (h, w), grey, with its shading.

    Args:
        picture: (h, w) printed spine, 0 to 255.
        light: share of the room's light that falls on it, 0 to 1.
        streak: place of a mirrored window, 0 to 1 from the left side; None: none is mirrored.
        gloss: share of the window's light that is mirrored, 0 to 1.
    """
    if light > 0.999 and streak is None:
        return picture
    across = (np.arange(picture.shape[1]) + 0.5) / picture.shape[1]
    added = 0.0 if streak is None else gloss * _STREAK_GREY * np.exp(-(((across - streak) / _STREAK) ** 2))
    return np.clip(picture * light + added, 0.0, 255.0).astype(np.uint8)


# A spine's picture: x to the right is -y of the book, y downwards is -z.
_SPINE_FACE = np.array(
    [[0.0, 0.0, 1.0, 0.0], [-1.0, 0.0, 0.0, 0.0], [0.0, -1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]]
)


def _part(canvas: Canvas, book: SimulatedBook, span: tuple[float, float], light: float) -> None:
    """Draw the part of a book between two depths, in one shade.

    Args:
        canvas: picture to draw on.
        book: the book.
        span: depths behind the spine at which the part begins and ends, in [m].
        light: share of the room's light that falls on it, 0 to 1.
    """
    middle = book.pose @ transform(((span[0] + span[1]) / 2, 0.0, book.height / 2))
    size = np.array([span[1] - span[0], book.thickness, book.height])
    normals = SIDE_NORMALS @ middle[:3, :3].T
    corners = (SIDE_CORNERS * size) @ middle[:3, :3].T + middle[:3, 3]
    cover = round(book.spec.grey * _COVER * light)
    for i, grey in (
        (1, round(_PAGES * light)),
        (2, cover),
        (3, cover),
        (4, cover),
        (5, round(_PAGES * light)),
        (0, cover),
    ):
        if canvas.seen_from_front(corners[i][0], normals[i]):
            canvas.polygon(corners[i], grey)


@lru_cache(maxsize=512)
def spine_levels(spec: BookSpec) -> list[tuple[ByteArray, float]]:
    """Return grey pictures (h, w) of a book's spine, the first one at full resolution, each further one at
    half the resolution of the one before.

    Each item of the list is a picture and the size of its pixels, in [m].
    """
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
        label_mm=spec.label_mm,
        lines=spec.label_lines,
    )
    levels = [(picture, 1e-3 / PX_PER_MM)]
    for _ in range(3):
        last, metres = levels[-1]
        # Cut to whole pairs, or the halved picture would be stretched.
        even = last[: last.shape[0] // 2 * 2, : last.shape[1] // 2 * 2]
        size = (even.shape[1] // 2, even.shape[0] // 2)
        levels.append((cv2.resize(even, size, interpolation=cv2.INTER_AREA).astype(np.uint8), 2 * metres))
    return levels
