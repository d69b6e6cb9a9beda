"""Labels read by comparing them with pictures of the known ones, as in the paper's SEARCH (section 3.3.4)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import cv2
import numpy as np
from typing_extensions import override

from handcart.robotics.numerics.arrays import ByteArray, FloatArray
from handcart.robotics.perception.books.call_number import CallNumber
from handcart.robotics.perception.books.label_reader import LabelReader, LabelReading, cut_to_print

_HEIGHT, _WIDTH = 20, 112  # templates are compared in this size, [px]
_SHIFTS = (-1, 0, 1)
_WIDTH_SLACK = 0.08
_LEAST_LEAD = 0.02  # of the best over the second, in correlation


class TemplateLabelReader(LabelReader):
    """Label reader that compares each crop with pictures of known labels, and returns the best match.

    It only reads labels of which it has a picture.
    """

    def __init__(self, templates: Mapping[CallNumber, ByteArray], px_per_m: float) -> None:
        """Prepare the templates.

        Args:
            templates: pictures (h, w), grey, of the known labels, text running left to right.
            px_per_m: scale of the pictures, in [px/m].
        """
        super().__init__()
        self._numbers = list(templates)
        scale = self.crop_height_px / (self.crop_height_m * px_per_m)
        cuts = [self._cut(templates[number], scale) for number in self._numbers]
        self._widths = np.array([cut.shape[1] for cut in cuts], dtype=np.float64)
        self._rows = np.stack([_normalised(cut) for cut in cuts]) if cuts else np.empty((0, _HEIGHT * _WIDTH))

    @override
    def read_crops(self, crops: Sequence[ByteArray]) -> list[LabelReading]:
        return [self._match(crop) for crop in crops]

    def _cut(self, template: ByteArray, scale: float) -> ByteArray:
        """Return a template as the camera's crops are: of the same scale and height, cut to its print."""
        resized = cv2.resize(template, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
        surplus = max(0, resized.shape[0] - self.crop_height_px) // 2
        return cut_to_print(resized[surplus : surplus + self.crop_height_px].astype(np.uint8))

    def _match(self, crop: ByteArray) -> LabelReading:
        likely = np.flatnonzero(np.abs(self._widths / crop.shape[1] - 1.0) < _WIDTH_SLACK)
        if len(likely) == 0:
            return LabelReading("", 0.0)
        shifted = [np.roll(crop, (down, right), axis=(0, 1)) for down in _SHIFTS for right in _SHIFTS]
        scores = (self._rows[likely] @ np.stack([_normalised(one) for one in shifted]).T).max(axis=1)
        order = np.argsort(-scores, kind="stable")
        best = float(scores[order[0]])
        if len(order) > 1 and best - float(scores[order[1]]) < _LEAST_LEAD:
            return LabelReading("", 0.0)
        return LabelReading(str(self._numbers[int(likely[order[0]])]), max(0.0, best))


def _normalised(crop: ByteArray) -> FloatArray:
    """Return a crop in the size of comparison, as a vector (n,) of mean 0 and length 1."""
    small = cv2.resize(crop, (_WIDTH, _HEIGHT), interpolation=cv2.INTER_AREA).astype(np.float64).ravel()
    small -= small.mean()
    unit: FloatArray = small / max(float(np.linalg.norm(small)), 1e-9)
    return unit
