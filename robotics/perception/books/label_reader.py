"""Reading the call-number labels in a view of the shelf."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from functools import partial
from typing import NamedTuple

import numpy as np

from handcart.robotics.numerics.arrays import BoolArray, ByteArray, FloatArray
from handcart.robotics.perception.books.call_number import CallNumber, parse, snap
from handcart.robotics.perception.books.label_box import LabelBox
from handcart.robotics.perception.books.label_finder import find_labels
from handcart.robotics.perception.books.text_lines import text_lines
from handcart.robotics.perception.cameras.camera_model import CameraModel, plane_to_rays

_CAP_HEIGHT_M = 0.005  # of capitals, where a crop shows `crop_height_m`
_SAME_PLACE, _SURE = 0.0025, 0.95  # [m] between views' places of one label; confidence
_PAGE_M_PER_PX, _PAGE_SHARE = 0.000177, 0.9  # how lines are looked for: scale, and what isn't the paper's rim


class Label(NamedTuple):
    """Label on a book as it was seen and read.

    `text` is the label's text as read, "" if unreadable. `call_number` is None if the text was not read as a
    call number. `confidence` is from 0 to 1. `corners` (4, 2) are in [px] of the image, beginning at the
    upper left of the printed text, then clockwise for somebody who reads the text. `lateral` and `height` are
    y and z of the label's middle in the shelf frame, and `width` is its size across the spine, all in [m].
    `lean` is the turn of its top to the left, as seen from the front, in [rad].
    """

    text: str
    call_number: CallNumber | None
    confidence: float
    corners: FloatArray
    lateral: float
    height: float
    width: float = 0.010
    lean: float = 0.0


class LabelReading(NamedTuple):
    """Text that a reader has read on one crop (a cut-out picture of a label), with confidence, 0 to 1."""

    text: str
    confidence: float


class LabelReader(ABC):
    """Base class of readers that read all labels in a picture of a shelf.

    This class cuts the picture into upright crops of one label each; subclasses read the crops.

    If a `catalogue` is given, each text is replaced by the nearest known call number, at most two edits away.
    If two call numbers are equally near, the result has none. Texts read with less than `least_confidence`
    give no call number either.
    """

    crop_height_px = 48
    crop_height_m = 0.0085
    """Height, in [m], of a crop of a line whose capitals are 5 mm high; it is scaled with them."""
    least_confidence = 0.5

    def __init__(self, catalogue: Sequence[CallNumber] | None = None) -> None:
        self._catalogue = catalogue

    @abstractmethod
    def read_crops(self, crops: Sequence[ByteArray]) -> list[LabelReading]:
        """Return the text read on each crop (a cut-out picture of a label), with its confidence.

        Args:
            crops: upright pictures (crop_height_px, w), grey, with text running left to right.
        """

    def read(
        self,
        image: ByteArray,
        camera: CameraModel,
        camera_T_shelf: FloatArray,
        mask: BoolArray | None = None,
        known: Sequence[Label] = (),
    ) -> list[Label]:
        """Read all labels that are completely visible in an image, and return them from left to right.

        Args:
            image: (h, w), grey.
            camera: model of the camera.
            camera_T_shelf: (4, 4) pose of the shelf, translation in [m]; it may be off by a few millimetres
                and degrees.
            mask: (h, w) True where the image shows the shelf; None: everywhere.
            known: labels that another view read with certainty; those are not read again.

        Raises:
            ValueError: the camera doesn't look at the shelf's front.
        """
        boxes = find_labels(image, camera, camera_T_shelf, mask)
        before = [_read_before(box, known) for box in boxes]
        fresh = [box for box, reading in zip(boxes, before, strict=True) if reading is None]
        crops = [self._crop(image, camera, camera_T_shelf, box) for box in fresh]
        readings = iter(self.read_crops(crops) if crops else [])
        found = [
            (box, self._label(box, reading or next(readings), camera, camera_T_shelf))
            for box, reading in zip(boxes, before, strict=True)
        ]
        # Print without a call number is a title.
        return [label for box, label in found if box.paper or label.call_number is not None]

    def _crop(
        self, image: ByteArray, camera: CameraModel, camera_T_shelf: FloatArray, box: LabelBox
    ) -> ByteArray:
        """Return a crop (crop_height_px, w), grey, of a label, cut to print.

        It is turned so that its text runs left to right, line after line.
        """
        flat = partial(_flat_label, image, camera, camera_T_shelf, box)
        lines = text_lines(
            flat(0.0, _PAGE_SHARE * box.width, round(_PAGE_SHARE * box.width / _PAGE_M_PER_PX))
        )
        tall = self.crop_height_m / _CAP_HEIGHT_M
        parts = [
            flat(line.middle * _PAGE_M_PER_PX, tall * line.cap * _PAGE_M_PER_PX, self.crop_height_px)
            for line in lines
        ]
        return np.hstack([cut_to_print(part) for part in parts])

    def _label(
        self, box: LabelBox, reading: LabelReading, camera: CameraModel, camera_T_shelf: FloatArray
    ) -> Label:
        number = parse(reading.text) if reading.confidence >= self.least_confidence else None
        if self._catalogue is not None and reading.text:
            number = snap(reading.text, self._catalogue)
        corners = camera.plane_in_image(box.corners[[1, 2, 3, 0]], camera_T_shelf)
        return Label(reading.text, number, reading.confidence, corners, *box.centre, box.width, box.lean)


def _read_before(box: LabelBox, known: Sequence[Label]) -> LabelReading | None:
    """Return the certain reading of a label at the same place; None without one, or with contradicting
    ones.
    """
    lateral, height = box.centre
    there = {
        label.text: LabelReading(label.text, label.confidence)
        for label in known
        if abs(label.lateral - lateral) < _SAME_PLACE
        and abs(label.height - height) < 2 * _SAME_PLACE
        and label.confidence >= _SURE
        and label.call_number is not None
    }
    return next(iter(there.values())) if len(there) == 1 else None


def _flat_label(
    image: ByteArray,
    camera: CameraModel,
    camera_T_shelf: FloatArray,
    box: LabelBox,
    below: float,
    height: float,
    rows: int,
) -> ByteArray:
    """Return a strip (rows, w) along a label, grey, as a reader of its text sees it.

    The strip's middle is `below` [m] below the label's; its `height` is in [m].
    """
    m_per_px = height / rows
    width = round(box.length / m_per_px)
    along = np.array(box.along)
    # Text's own right is towards the book's foot, its down is to the left (+y) of the shelf.
    down = np.array([-along[1], along[0]])
    start = np.array(box.centre) - (width - 1) / 2 * m_per_px * along
    start = start + (below - (rows - 1) / 2 * m_per_px) * down
    to_plane = np.eye(3)
    to_plane[:2] = np.column_stack([along * m_per_px, down * m_per_px, start])
    return camera.rectify(image, plane_to_rays(camera_T_shelf) @ to_plane, (width, rows))


def cut_to_print(crop: ByteArray) -> ByteArray:
    """Return a crop (h, k), grey, without the empty paper before and after the text.

    A margin of a fifth of the crop's height stays on both sides.

    Args:
        crop: (h, w), grey.
    """
    height, width = crop.shape
    inner = crop[height // 6 : -height // 6]
    white, black = np.percentile(inner, (90, 1))
    # The rims of the paper are dark too: the cover shows there.
    edge = height // 8
    inked = np.flatnonzero((inner[:, edge:-edge] < (white + black) / 2).any(axis=0)) + edge
    if len(inked) == 0:
        return crop
    margin = height // 5
    return np.ascontiguousarray(crop[:, max(0, inked[0] - margin) : min(width, inked[-1] + margin)])
