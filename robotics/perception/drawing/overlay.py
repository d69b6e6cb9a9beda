"""Drawing of detections into a copy of the image."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import cv2
import numpy as np

from handcart.robotics.numerics.arrays import ByteArray, FloatArray
from handcart.robotics.perception.books.label_reader import Label
from handcart.robotics.perception.books.slots import Gap
from handcart.robotics.perception.books.spines import Spine
from handcart.robotics.perception.cameras.camera_model import CameraModel
from handcart.robotics.perception.landmarks.landmark import Landmark
from handcart.robotics.perception.landmarks.tag_reader import Tag

_TAG, _READ, _UNREAD, _GAP, _SPINE = (255, 128, 0), (0, 200, 0), (0, 0, 230), (0, 200, 255), (200, 160, 60)
_HEIGHTS = np.linspace(0.0, 0.2, 9)
_FONT, _LETTERS = cv2.FONT_HERSHEY_SIMPLEX, 0.38


class _Box(NamedTuple):
    """Rectangle of a written text, in complete pixels."""

    left: int
    top: int
    right: int
    bottom: int

    def meets(self, other: _Box) -> bool:
        across = min(self.right, other.right) > max(self.left, other.left)
        return across and min(self.bottom, other.bottom) > max(self.top, other.top)

    def raised(self, by: int) -> _Box:
        return self._replace(top=self.top - by, bottom=self.bottom - by)


def draw_overlay(
    image: ByteArray,
    tags: Sequence[Tag] = (),
    labels: Sequence[Label] = (),
    spines: Sequence[Spine] = (),
    gaps: Sequence[Gap] = (),
    camera: CameraModel | None = None,
    camera_T_shelf: FloatArray | None = None,
    landmarks: Sequence[Landmark] = (),
    outlines: Sequence[FloatArray] = (),
    points: FloatArray | None = None,
) -> ByteArray:
    """Return a BGR copy (h, w, 3) of an image with detections drawn into it.

    Args:
        image: (h, w), grey.
        tags: tags, drawn with their numbers.
        labels: labels, drawn with their texts.
        spines: spines in the shelf frame; drawn if camera and `camera_T_shelf` are given.
        gaps: gaps in the shelf frame; drawn as `spines` are.
        camera: model of the camera.
        camera_T_shelf: (4, 4) pose of the shelf, translation in [m].
        landmarks: landmarks, drawn with their centres.
        outlines: polygons (n, 2), column and row in [px], drawn closed.
        points: (n, 2) column and row in [px], drawn as small circles.
    """
    picture = np.asarray(cv2.cvtColor(image, cv2.COLOR_GRAY2BGR), dtype=np.uint8)
    words: list[_Box] = []
    for tag in tags:
        _outline(picture, tag.corners, _TAG)
        _write(picture, str(tag.id), tag.corners.max(axis=0), _TAG, words)
    for label in labels:
        colour = _READ if label.call_number is not None else _UNREAD
        _outline(picture, label.corners, colour)
        text = str(label.call_number) if label.call_number is not None else label.text or "?"
        _write(picture, text, label.corners.min(axis=0) - (12, 6), colour, words)
    for landmark in landmarks:
        _outline(picture, landmark.corners, _TAG)
        _outline(picture, np.vstack([landmark.corners[0], landmark.centre]), _TAG, closed=False)
    for outline in outlines:
        _outline(picture, outline, _READ)
    for x, y in np.rint(() if points is None else points * 16).astype(int).tolist():
        cv2.circle(picture, (x, y), 3 * 16, _READ, 1, cv2.LINE_AA, 4)
    if camera is not None and camera_T_shelf is not None:
        for things, colour in ((spines, _SPINE), (gaps, _GAP)):
            for thing in things:
                for y in (thing.left, thing.right):
                    _upright(picture, camera, camera_T_shelf, y, colour)
    return picture


def _outline(
    picture: ByteArray, points: FloatArray, colour: tuple[int, int, int], closed: bool = True
) -> None:
    # Four fractional bits: lines fall between pixels as the corners do.
    fixed = np.rint(points * 16).astype(np.int32).reshape(-1, 1, 2)
    cv2.polylines(picture, [fixed], closed, colour, 1, cv2.LINE_AA, 4)


def _upright(
    picture: ByteArray,
    camera: CameraModel,
    camera_T_shelf: FloatArray,
    y: float,
    colour: tuple[int, int, int],
) -> None:
    points = camera.plane_in_image(np.column_stack([np.full(len(_HEIGHTS), y), _HEIGHTS]), camera_T_shelf)
    if np.isfinite(points).all():
        _outline(picture, np.clip(points, -4000, 4000), colour, closed=False)


def _write(
    picture: ByteArray, text: str, at: FloatArray, colour: tuple[int, int, int], words: list[_Box]
) -> None:
    """Write a text at a point, or above earlier texts there; add its box to `words`."""
    (width, height), below = cv2.getTextSize(text, _FONT, _LETTERS, 3)
    x = int(np.clip(at[0], 0, max(0, picture.shape[1] - width)))
    y = int(np.clip(at[1], height, picture.shape[0] - below))
    box = _Box(x, y - height, x + width, y + below)
    while any(box.meets(word) for word in words) and box.top >= height:
        box = box.raised(height + below)
    words.append(box)
    where = box.left, box.bottom - below
    cv2.putText(picture, text, where, _FONT, _LETTERS, (0, 0, 0), 3, cv2.LINE_AA)
    cv2.putText(picture, text, where, _FONT, _LETTERS, colour, 1, cv2.LINE_AA)
