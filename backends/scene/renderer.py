"""What the camera on the hand sees."""

from __future__ import annotations

from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from handcart.backends.simulated_errors import Errors
from handcart.robotics.geometry.transform import Transform, transform
from handcart.robotics.kinematics.shapes import Box
from handcart.robotics.perception.camera_model import CameraModel

from .book import Book
from .canvas import Canvas
from .lens import Lens
from .scene import Scene
from .shelf import DEPTH, Shelf
from .textures import PX_PER_MM, draw_spine
from .thing import Rest
from .world_file import BookSpec

GreyImage = NDArray[np.uint8]

_BACKGROUND, _FLOOR, _WALL, _FURNITURE = 150, 95, 165, 110
_WOOD, _INSIDE, _DEPTH_DARK, _BOARD = 130, 14, 18, 60
_PAGES, _METAL = 200, 90
_SEES = 3.0  # shelves further away are painted without their books [m]
_FACES = (
    # normal, and corners of the unit box about its middle
    ((-1, 0, 0), ((-1, -1, -1), (-1, 1, -1), (-1, 1, 1), (-1, -1, 1))),
    ((1, 0, 0), ((1, -1, -1), (1, 1, -1), (1, 1, 1), (1, -1, 1))),
    ((0, -1, 0), ((-1, -1, -1), (1, -1, -1), (1, -1, 1), (-1, -1, 1))),
    ((0, 1, 0), ((-1, 1, -1), (1, 1, -1), (1, 1, 1), (-1, 1, 1))),
    ((0, 0, -1), ((-1, -1, -1), (1, -1, -1), (1, 1, -1), (-1, 1, -1))),
    ((0, 0, 1), ((-1, -1, 1), (1, -1, 1), (1, 1, 1), (-1, 1, 1))),
)
_NORMALS = np.array([face[0] for face in _FACES], dtype=float)
_CORNERS = np.array([face[1] for face in _FACES], dtype=float) / 2
_SHADE = (1.0, 0.6, 0.8, 0.85, 0.4, 1.1)  # light comes from above and from before the shelves


class Renderer:
    """Paints a scene for one camera: far things first, convex bodies face by face.

    Spines and marks are printed; all else is flat shades. What stands deep in a shelf is dark. Not shown:
    the arm beyond its fingers, the base, fallen books.
    """

    def __init__(self, camera: CameraModel, errors: Errors, seed: int) -> None:
        self._lens = Lens(camera, errors, seed)

    def render(self, scene: Scene, world_T_camera: Transform, period: int) -> GreyImage:
        """The picture (height, width) taken from a pose (4, 4) in this period."""
        return self._lens.take(self.ideal(scene, world_T_camera), period)

    def ideal(self, scene: Scene, world_T_camera: Transform) -> GreyImage:
        """The same without lens, light and noise; larger."""
        canvas = Canvas(self._lens.K, self._lens.size, world_T_camera, _BACKGROUND)
        _room(canvas, scene)
        for mark in scene.marks:
            if canvas.seen_from_front(mark.pose[:3, 3], mark.pose[:3, 2]):
                canvas.texture(mark.levels(), mark.face())
        _blocks(canvas, scene, {Rest.TABLE, Rest.FLOOR})
        shelves = sorted(
            scene.shelves.values(), key=lambda s: -float(np.linalg.norm(s.pose[:3, 3] - canvas.eye))
        )
        for shelf in shelves:
            _shelf(canvas, scene, shelf)
        _robot(canvas, scene)
        return canvas.picture


def _room(canvas: Canvas, scene: Scene) -> None:
    x, y = canvas.eye[:2]
    floor = np.array([[-30, -30, 0], [30, -30, 0], [30, 30, 0], [-30, 30, 0]]) + np.array([x, y, 0.0])
    canvas.polygon(floor, _FLOOR)
    shelf_parts = len(scene.solids) - sum(len(shelf.parts()) for shelf in scene.shelves.values())
    there = [s.box for s in scene.solids[:shelf_parts] if s.appears <= scene.time < s.leaves]
    # Walls behind furniture: seen from within a room nothing stands behind a wall that hides it.
    there.sort(key=lambda box: (box.size[2] < 2.0, -float(np.linalg.norm(box.pose[:2, 3] - canvas.eye[:2]))))
    for box in there:
        _box(canvas, box, _WALL if box.name.startswith("wall") else _FURNITURE)


def _blocks(canvas: Canvas, scene: Scene, resting: set[Rest]) -> None:
    """The blocks that rest so, the nearest one last."""
    there = [block for block in scene.blocks.values() if block.rest in resting]
    there.sort(key=lambda block: -float(np.linalg.norm(block.box().pose[:3, 3] - canvas.eye)))
    for block in there:
        _box(canvas, block.box(), block.spec.grey)


def _box(canvas: Canvas, box: Box, grey: int, faces: tuple[int, ...] = (0, 1, 2, 3, 4, 5)) -> None:
    normals = _NORMALS @ box.pose[:3, :3].T
    corners = (_CORNERS * np.array(box.size)) @ box.pose[:3, :3].T + box.pose[:3, 3]
    for i in faces:
        if canvas.seen_from_front(corners[i][0], normals[i]):
            canvas.polygon(corners[i], min(255, round(grey * _SHADE[i])))


def _shelf(canvas: Canvas, scene: Scene, shelf: Shelf) -> None:
    parts = shelf.parts()
    eye = shelf.inverse_pose[:3, :3] @ canvas.eye + shelf.inverse_pose[:3, 3]
    if eye[0] >= 0.0 or np.linalg.norm(eye) > _SEES:
        for part in ("plinth", "board", "left panel", "right panel", "back"):
            _box(canvas, parts[part], _WOOD)
        return
    _inside(canvas, shelf)
    ends = [parts["book end"]] if "book end" in parts else []
    bodies: list[tuple[float, Book | Box]] = [
        (_to_row(each.lateral, each.book.thickness, eye[1]), each.book)
        for each in scene.shelf_books(shelf.name)
    ]
    bodies += [
        (_to_row((shelf.book_end_left - shelf.half_width) / 2, box.size[1], eye[1]), box) for box in ends
    ]
    held = _held_inside(scene, shelf)
    if held is not None:
        lateral = float((shelf.inverse_pose @ held.pose)[1, 3])
        bodies.append((_to_row(lateral, held.thickness, eye[1]), held))
    # Between parallel bodies side by side the one further to the side never hides the nearer one.
    for _, body in sorted(bodies, key=lambda each: -each[0]):
        if isinstance(body, Book):
            _book(canvas, body, shelf)
        else:
            _box(canvas, body, _METAL)
    # Faces that look into the shelf are painted already, and books stand before them.
    for part, faces in (("plinth", (0,)), ("left panel", (0, 3, 5)), ("right panel", (0, 2, 5))):
        _box(canvas, parts[part], _WOOD, faces)
    _board_edge(canvas, shelf)


def _to_row(lateral: float, thickness: float, eye: float) -> float:
    return max(0.0, abs(lateral - eye) - thickness / 2)


def _held_inside(scene: Scene, shelf: Shelf) -> Book | None:
    """The held book, if it reaches into the shelf: its neighbours may hide it."""
    held = scene.held
    if not isinstance(held, Book):
        return None
    fore = shelf.inverse_pose @ held.pose @ np.array([held.depth, 0.0, 0.0, 1.0])
    inside = 0.0 < fore[0] < DEPTH and abs(fore[1]) < shelf.half_width and -0.1 < fore[2] < 0.3
    return held if inside else None


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
    canvas.polygon(_in_world(shelf, corners), _WOOD + 20)


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
    normals = _NORMALS @ middle[:3, :3].T
    corners = (_CORNERS * size) @ middle[:3, :3].T + middle[:3, 3]
    for i, grey in ((1, head), (2, cover), (3, cover), (4, cover), (5, head), (0, cover)):
        if canvas.seen_from_front(corners[i][0], normals[i]):
            canvas.polygon(corners[i], grey)


def _robot(canvas: Canvas, scene: Scene) -> None:
    """Tray and what stands on it, then the hand's load and fingers: nothing comes before them."""
    if scene.arm is None:
        return
    if scene.robot.has_tray:
        tray = scene.robot.tray_shape
        middle = scene.world_T_base @ transform((*tray.middle, tray.top - tray.size[2] / 2))
        _box(canvas, Box(middle, tray.size), scene.robot.tray_grey)
    standing = scene.tray_book()
    if standing is not None:
        _book(canvas, standing, None)
    _blocks(canvas, scene, {Rest.TRAY})
    held = scene.held
    if isinstance(held, Book) and not any(_held_inside(scene, s) for s in scene.shelves.values()):
        _book(canvas, held, None)
    _blocks(canvas, scene, {Rest.HAND})
    if scene.robot.gripper is None:
        return
    hand, finger = scene.world_T("hand"), scene.robot.finger_shape
    for side in (-1.0, 1.0):
        middle = hand @ transform(
            (finger.tip - finger.length / 2, side * (scene.width + finger.thickness) / 2, 0.0)
        )
        _box(canvas, Box(middle, (finger.length, finger.thickness, finger.height)), _METAL)


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
