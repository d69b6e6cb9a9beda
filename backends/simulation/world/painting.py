"""Appearance of boxes without physics."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import cv2
import numpy as np

from handcart.backends.simulation.world.sheet import Levels, Sheet
from handcart.backends.simulation.world.thing import Side, Thing
from handcart.robotics.geometry.transform import Transform, transform
from handcart.robotics.kinematics.shapes import Box
from handcart.robotics.numerics.arrays import ByteArray, FloatArray

from .canvas import Canvas

BOX_SIDES: tuple[Side, ...] = ("-x", "+x", "-y", "+y", "-z", "+z")
SIDE_NORMALS = np.array([(-1, 0, 0), (1, 0, 0), (0, -1, 0), (0, 1, 0), (0, 0, -1), (0, 0, 1)], dtype=float)
"""Outward unit normals (6, 3) of a box's sides, in the order of `BOX_SIDES`."""
_CORNERS = (
    ((-1, -1, -1), (-1, 1, -1), (-1, 1, 1), (-1, -1, 1)),
    ((1, -1, -1), (1, 1, -1), (1, 1, 1), (1, -1, 1)),
    ((-1, -1, -1), (1, -1, -1), (1, -1, 1), (-1, -1, 1)),
    ((-1, 1, -1), (1, 1, -1), (1, 1, 1), (-1, 1, 1)),
    ((-1, -1, -1), (1, -1, -1), (1, 1, -1), (-1, 1, -1)),
    ((-1, -1, 1), (1, -1, 1), (1, 1, 1), (-1, 1, 1)),
)
SIDE_CORNERS = np.array(_CORNERS, dtype=float) / 2
"""Corners (6, 4, 3) of the sides of a box of length 1 around its middle, in the order of `BOX_SIDES`."""
_SHADE = (1.0, 0.6, 0.8, 0.85, 0.4, 1.1)  # light comes from above and from before the robot's docking places
_PICTURES: dict[Side, tuple[int, int, float, float, float]] = {
    # the size's axes along rows and columns; roll, pitch, yaw of the picture's frame, its y down
    "-x": (1, 2, -np.pi / 2, 0.0, -np.pi / 2),
    "+x": (1, 2, -np.pi / 2, 0.0, np.pi / 2),
    "-y": (0, 2, -np.pi / 2, 0.0, 0.0),
    "+y": (0, 2, -np.pi / 2, 0.0, np.pi),
    "-z": (0, 1, 0.0, 0.0, 0.0),
    "+z": (0, 1, np.pi, 0.0, 0.0),
}


ROUND_STRIPS = 24  # of a cylinder's side
INSCRIBED_SQUARE_RATIO = float(np.sqrt(0.5))  # of a circle's diameter: side of the square within


class Painted(NamedTuple):
    """Object of a scene as the function that paints it, and the box around it."""

    box: Box
    """Box around the object, in the world, by which it is painted before objects that hide it."""
    paint: Callable[[Canvas], None]


def paint_thing(thing: Thing) -> Painted:
    """Return a box or cylinder as a drawable object, in its grey, with the pictures that are printed on
    it.
    """
    return Painted(thing.box(), partial(_thing, thing=thing))


def plain_box(box: Box, grey: int) -> Painted:
    """Return a box of one grey, 0 to 255, as a drawable object."""
    return Painted(box, partial(paint_box, box=box, grey=grey))


def paint_sheet(sheet: Sheet) -> Painted:
    """Return a printed sheet as a drawable object, which is seen from above."""
    picture, metres = sheet.levels[0]
    height, width = picture.shape
    return Painted(Box(sheet.pose, (width * metres, height * metres, 0.0)), partial(_sheet, sheet=sheet))


def paint_box(canvas: Canvas, box: Box, grey: int, sides: tuple[int, ...] = (0, 1, 2, 3, 4, 5)) -> None:
    """Paint the sides of a box that face the camera, each in its shade.

    Args:
        canvas: picture to paint on.
        box: the box, posed in the world.
        grey: grey of a fully lit side, 0 to 255.
        sides: indices in `BOX_SIDES` of the sides that are painted, if they face the camera.
    """
    normals = SIDE_NORMALS @ box.pose[:3, :3].T
    corners = (SIDE_CORNERS * np.array(box.size)) @ box.pose[:3, :3].T + box.pose[:3, 3]
    for i in sides:
        if canvas.seen_from_front(corners[i][0], normals[i]):
            canvas.polygon(corners[i], min(255, round(grey * _SHADE[i])))


def _sheet(canvas: Canvas, sheet: Sheet) -> None:
    if canvas.seen_from_front(sheet.pose[:3, 3], sheet.pose[:3, 2]):
        canvas.texture(sheet.levels, sheet.face())


def _thing(canvas: Canvas, thing: Thing) -> None:
    if thing.is_round:
        _round_thing(canvas, thing)
        return
    box, faces = thing.box(), thing.faces()
    plain = tuple(i for i, side in enumerate(BOX_SIDES) if side not in faces)
    paint_box(canvas, box, thing.grey, plain)
    for side, picture in faces.items():
        face, (width, height) = picture_frame(side, box)
        if canvas.seen_from_front(face[:3, 3], -face[:3, 2]):
            canvas.texture(picture_levels(picture, width, height), face)


def _round_thing(canvas: Canvas, thing: Thing) -> None:
    """Paint a cylinder: its side in strips, its ends with the middle of the pictures on them."""
    box = thing.box()
    turn, place = box.pose[:3, :3].T, box.pose[:3, 3]
    for corners, normal in round_strips(box.size):
        if canvas.seen_from_front(corners[0] @ turn + place, normal @ turn):
            share = _SHADE[4] + (_SHADE[5] - _SHADE[4]) * (1.0 + float((normal @ turn)[2])) / 2
            canvas.polygon(corners @ turn + place, min(255, round(thing.grey * share)))
    inner = Box(
        box.pose, (box.size[0] * INSCRIBED_SQUARE_RATIO, box.size[1] * INSCRIBED_SQUARE_RATIO, box.size[2])
    )
    for side, picture in thing.faces().items():
        face, (width, height) = picture_frame(side, inner)
        if canvas.seen_from_front(face[:3, 3], -face[:3, 2]):
            rows, columns = (round(item * (1.0 - INSCRIBED_SQUARE_RATIO) / 2) for item in picture.shape)
            middle = picture[rows : picture.shape[0] - rows, columns : picture.shape[1] - columns]
            canvas.texture(picture_levels(middle, width, height), face)


def round_strips(size: tuple[float, float, float]) -> list[tuple[FloatArray, FloatArray]]:
    """Return the flat faces that approximate a cylinder along z: strips of its side, and both ends.

    Args:
        size: size of the box around the cylinder along x, y and z, in [m].

    Returns:
        Corners (n, 3) of each face, relative to the cylinder's middle in [m], and its outward unit
        normal (3,).
    """
    angles = np.arange(ROUND_STRIPS) * (2.0 * np.pi / ROUND_STRIPS)
    ring = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(ROUND_STRIPS)]) * (size[0] / 2)
    up = np.array([0.0, 0.0, size[2] / 2])
    following = np.roll(ring, -1, axis=0)
    strips = [
        (np.array([a - up, b - up, b + up, a + up]), (a + b) / np.linalg.norm(a + b))
        for a, b in zip(ring, following, strict=True)
    ]
    return [*strips, (ring[::-1] - up, -up / size[2] * 2.0), (ring + up, up / size[2] * 2.0)]


def picture_frame(side: Side, box: Box) -> tuple[Transform, tuple[float, float]]:
    """Return the frame (4, 4) of the picture on a box's side, and the picture's width and height in [m].

    The frame's origin is in the picture's upper left corner; x is along the rows, y down the columns, z into
    the box. It is given in the same frame as `box.pose`, for example the world.
    """
    along, down, *turn = _PICTURES[side]
    size = (box.size[along], box.size[down])
    out = SIDE_NORMALS[BOX_SIDES.index(side)] * np.array(box.size) / 2
    middle = transform(tuple(out.tolist()), tuple(turn))
    return box.pose @ middle @ transform((-size[0] / 2, -size[1] / 2, 0.0)), size


def picture_levels(picture: ByteArray, width: float, height: float) -> Levels:
    """Return a grey picture on a box's face with square pixels, at full resolution and then halved several
    times.

    Each level is a picture (h, w) and the size of its pixels in [m].

    Args:
        picture: (h, w), fills the face of the box.
        width: width of the face, in [m].
        height: height of the face, in [m].
    """
    metres = min(width / picture.shape[1], height / picture.shape[0])
    size = (max(1, round(width / metres)), max(1, round(height / metres)))
    if size != picture.shape[::-1]:
        picture = cv2.resize(picture, size, interpolation=cv2.INTER_LINEAR).astype(np.uint8, copy=False)
    levels = [(picture, metres)]
    while min(levels[-1][0].shape) >= 8:
        last, metres = levels[-1]
        half = (last.shape[1] // 2, last.shape[0] // 2)
        even = last[: half[1] * 2, : half[0] * 2]  # else the halved picture would be stretched
        levels.append((cv2.resize(even, half, interpolation=cv2.INTER_AREA).astype(np.uint8), 2 * metres))
    return levels
