"""Pose of the top face of a block in a picture."""

from __future__ import annotations

import math
from collections.abc import Iterator

import cv2
import numpy as np

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import Transform, apply
from handcart.robotics.numerics.arrays import ByteArray, FloatArray, SingleArray
from handcart.robotics.perception.blocks.plane_view import PlaneView
from handcart.robotics.perception.blocks.rectangle_edges import fit_rectangle
from handcart.robotics.perception.cameras.camera_model import CameraModel

MAX_TURN_RAD = 0.35
"""Largest difference from the expected heading, in [rad]."""
_ANGLES = np.linspace(-MAX_TURN_RAD, MAX_TURN_RAD, 11)
_M_PER_PX = 0.0016  # of the picture of the plane in which guesses are looked for
MIN_FACE_SIZE_M = 0.015
_STRIP = 3  # breadth of what is compared on both sides of an edge [px]
_LEAST_STEP = 5.0  # grey levels
_GUESSES = 6
_SAME = 0.003  # guesses nearer to each other than this are one [m]
_NEARER = 3.0  # weight of a guess within `within` of the expected position


def find_block(
    image: ByteArray,
    camera: CameraModel,
    camera_T_plane: Transform,
    size: tuple[float, float],
    expected: Pose2,
    within: float,
) -> Pose2 | None:
    """Return plane_T_block of the top face of a block in the plane z = 0 of a frame; None if it is not found.

    The face must be completely in the image, of one shade, and brighter than its surroundings. At one of its
    four edges, the surroundings may be as bright as the face; this edge is then computed from the size. A
    face whose size is off by 2 mm is not found. A lower block looks smaller, so blocks of the same kind in
    different layers are distinguished.

    Args:
        image: (h, w), grey.
        camera: model of the camera.
        camera_T_plane: (4, 4) pose of the frame.
        size: length and width of the face, in [m].
        expected: expected plane_T_block, with x along the length; the block may be turned from it by up to
            `MAX_TURN_RAD`.
        within: largest distance of the centre from the expected one, in [m].

    Raises:
        ValueError: the plane doesn't lie before the camera, or the size is less than 15 mm.
    """
    if min(size) < MIN_FACE_SIZE_M:
        raise ValueError(
            f"a face of {size[0]:g} x {size[1]:g} m is too small; allowed: {MIN_FACE_SIZE_M:g} m or more"
        )
    view = PlaneView(image, camera, camera_T_plane)
    for guess in _guesses(view, size, expected, within):
        found = fit_rectangle(view, size, guess)
        if found is not None and found.distance(expected) <= within and found.turn(expected) <= MAX_TURN_RAD:
            return found
    return None


def _guesses(view: PlaneView, size: tuple[float, float], expected: Pose2, within: float) -> Iterator[Pose2]:
    """Yield rough poses of the face, the best guess first, good to 1 mm and 0.04 rad."""
    picture = _picture(view, expected, math.hypot(*size) / 2 + within)
    scores = _scores(picture, size, within)
    count = scores.shape[1]
    offsets = (np.arange(count) - count // 2) * _M_PER_PX
    away = np.hypot(offsets[:, None], offsets)
    scores = np.where(away <= within + _M_PER_PX, scores - _NEARER * away / max(within, _M_PER_PX), 0.0)
    for _ in range(_GUESSES):
        turn, row, column = np.unravel_index(int(scores.argmax()), scores.shape)
        if scores[turn, row, column] <= 0.0:
            return
        angle, x, y = float(_ANGLES[turn]), float(offsets[column]), float(offsets[row])
        cos, sin = math.cos(angle), math.sin(angle)
        # Places were counted along the turned axes.
        yield expected.compose(Pose2(cos * x - sin * y, sin * x + cos * y, angle))
        scores[:, np.hypot(offsets[:, None] - y, offsets - x) < _SAME] = 0.0


def _picture(view: PlaneView, expected: Pose2, half: float) -> ByteArray:
    """Return a picture (n, n) of the plane about the expected pose, which is in the middle.

    x grows with the column, y with the row, in the frame of the expected pose.
    """
    half_px = math.ceil(half / _M_PER_PX) + 2 * _STRIP
    side = 2 * half_px + 1
    camera_T_expected = view.camera_T_plane @ expected.lift()
    start = -half_px * _M_PER_PX
    corners = np.array([[x, y, 0.0] for x in (start, -start) for y in (start, -start)])
    if apply(camera_T_expected, corners)[:, 2].min() <= 0.0:
        raise ValueError("the plane does not lie before the camera")
    to_plane = np.array([[_M_PER_PX, 0.0, start], [0.0, _M_PER_PX, start], [0.0, 0.0, 1.0]])
    return view.camera.rectify(view.image, camera_T_expected[:, (0, 1, 3)][:3] @ to_plane, (side, side))


def _scores(picture: ByteArray, size: tuple[float, float], within: float) -> FloatArray:
    """Return the contrast of a face of that size at each turn and position (turns, n, n)."""
    reach = math.ceil(within / _M_PER_PX) + 1
    half = [value / 2 / _M_PER_PX for value in size]
    # From the middle to the middles of the strips inside and outside of an edge.
    inner = [round(item - (_STRIP + 1) / 2) for item in half]
    outer = [item + _STRIP + 1 for item in inner]
    columns, rows = (reach + item for item in outer)
    turned = _turned(picture, columns, rows)
    long, wide = (2 * round(item) - _STRIP for item in half)
    ends, sides = (
        np.asarray(cv2.blur(turned, window), dtype=np.float32).reshape(len(_ANGLES), -1, 2 * columns + 1)
        for window in ((_STRIP, wide), (long, _STRIP))
    )
    steps = [_cut(ends, x * inner[0], 0, reach) - _cut(ends, x * outer[0], 0, reach) for x in (-1, 1)]
    steps += [_cut(sides, 0, y * inner[1], reach) - _cut(sides, 0, y * outer[1], reach) for y in (-1, 1)]
    left, right, low, high = steps
    second = np.minimum(
        np.maximum(np.minimum(left, right), np.minimum(low, high)),
        np.minimum(np.maximum(left, right), np.maximum(low, high)),
    )
    # Steps are of many heights: by their roots all four count.
    score = np.sum([np.copysign(np.sqrt(np.abs(step)), step) for step in steps], axis=0)
    return np.where(second >= _LEAST_STEP, score, 0.0)


def _turned(picture: ByteArray, columns: int, rows: int) -> SingleArray:
    """Return the picture in all turns, (turns * height, width), one below the other, about its middle."""
    middle = picture.shape[0] // 2
    width, height = 2 * columns + 1, 2 * rows + 1
    turned = np.empty((len(_ANGLES) * height, width), dtype=np.float32)
    for i, angle in enumerate(_ANGLES.tolist()):
        cos, sin = math.cos(angle), math.sin(angle)
        origin = middle - cos * columns + sin * rows, middle - sin * columns - cos * rows
        to_picture = np.array([[cos, -sin, origin[0]], [sin, cos, origin[1]]])
        flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        turned[i * height : (i + 1) * height] = cv2.warpAffine(
            picture, to_picture, (width, height), flags=flags
        )
    return turned


def _cut(stack: SingleArray, x: int, y: int, reach: int) -> SingleArray:
    """Return the middle (turns, n, n) of a stack of pictures, displaced by whole pixels."""
    _, height, width = stack.shape
    row, column = height // 2 + y, width // 2 + x
    return stack[:, row - reach : row + reach + 1, column - reach : column + reach + 1]
