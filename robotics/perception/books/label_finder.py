"""Finding call-number labels: bright upright rectangles of known size with dark print on them."""

from __future__ import annotations

import cv2
import numpy as np

from handcart.robotics.numerics.arrays import BoolArray, ByteArray, FloatArray, SingleArray
from handcart.robotics.perception.books.flat_view import FlatView, flat_view
from handcart.robotics.perception.books.label_box import LabelBox
from handcart.robotics.perception.books.print_finder import find_prints
from handcart.robotics.perception.cameras.bright_patches import BrightPatches
from handcart.robotics.perception.cameras.camera_model import CameraModel

_WIDTHS, _LENGTHS = (0.0052, 0.0265), (0.015, 0.090)  # across and along the spine, [m]
_LEVELS = range(70, 236, 15)
_CLOSED = ((7, 5), (15, 1))  # [px]
_INK_SHARE = (0.04, 0.6)
_SQUARE = 8  # the weight of being square against that of being large


def find_labels(
    image: ByteArray, camera: CameraModel, camera_T_shelf: FloatArray, mask: BoolArray | None = None
) -> list[LabelBox]:
    """Return the rectangles of all labels that are completely visible in an image, from left to right.

    On a cover as bright as paper a label's border is not visible, so any print there counts as a label.

    Args:
        image: (h, w), grey.
        camera: model of the camera.
        camera_T_shelf: (4, 4) pose of the shelf, translation in [m]; it may be off by a few millimetres
            and degrees.
        mask: (h, w) True where the image shows the shelf; None: everywhere.

    Raises:
        ValueError: the camera doesn't look at the shelf's front.
    """
    view = flat_view(image, camera, camera_T_shelf, mask)
    best: dict[tuple[int, int], tuple[float, LabelBox]] = {}
    for paper in _papers(view):
        for level in _LEVELS:
            for squareness, box in _patches(paper, level, view):
                near = next((key for key in best if _same_place(key, box)), None)
                if near is None:
                    near = (round(box.centre[0] * 1000), round(box.centre[1] * 1000))
                # A label whose end is cut off by print is square as well: the larger one is the label.
                worth = squareness**_SQUARE * box.length * box.width
                if near not in best or worth > best[near][0]:
                    best[near] = (worth, box)
    boxes = [box for _, box in best.values() if _printed(view, box)]
    boxes += [box for box in find_prints(view) if not any(_within(box, other) for other in boxes)]
    return sorted(boxes, key=lambda box: -box.centre[0])


def _papers(view: FlatView) -> list[ByteArray]:
    """Return the view, twice (h, w), with print painted over, which leaves paper as one bright patch.

    Print is thinner than 3 mm.
    Closing also removes the seams beside a label as broad as its spine, so the second view is closed along
    spines only.
    """
    papers = [
        np.asarray(cv2.morphologyEx(view.picture, cv2.MORPH_CLOSE, np.ones(size, np.uint8)), np.uint8)
        for size in _CLOSED
    ]
    for paper in papers:
        paper[~view.seen] = 0
    return papers


def _within(box: LabelBox, other: LabelBox) -> bool:
    """Return True if the centre of a box is in another one."""
    return (
        abs(box.centre[0] - other.centre[0]) < other.width / 2
        and abs(box.centre[1] - other.centre[1]) < other.length / 2
    )


def _same_place(key: tuple[int, int], box: LabelBox) -> bool:
    return abs(key[0] - box.centre[0] * 1000) < 6 and abs(key[1] - box.centre[1] * 1000) < 30


def _patches(paper: ByteArray, level: int, view: FlatView) -> list[tuple[float, LabelBox]]:
    """Bright patches of a label's size and shape, with how much of their rectangle they fill."""
    patches, found = BrightPatches(paper, level), []
    for number, (x, y, width, height, area) in enumerate(patches.boxes.tolist()):
        if not _label_sized(width * view.m_per_px, height * view.m_per_px, slack=1.4):
            continue
        if x == 0 or y == 0 or x + width == paper.shape[1] or y + height == paper.shape[0]:
            continue
        outline = max(
            cv2.findContours(patches.mask(number), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)[0], key=len
        )
        corners = cv2.boxPoints(cv2.minAreaRect(outline)) + np.array([x, y])
        box = _box(corners, view)
        filled = area * view.m_per_px**2 / (box.length * box.width)
        if filled > 0.85 and _label_sized(box.width, box.length):
            found.append((min(filled, 1.0), box))
    return found


def _label_sized(width: float, length: float, slack: float = 1.0) -> bool:
    return (
        _WIDTHS[0] / slack <= width <= _WIDTHS[1] * slack
        and _LENGTHS[0] / slack <= length <= _LENGTHS[1] * slack
    )


def _box(corners: SingleArray, view: FlatView) -> LabelBox:
    """Return the rectangle of four picture corners (any order, pixel centres of the rim) as a box in the
    shelf frame.
    """
    centre = corners.mean(axis=0)
    sides = np.diff(corners[[0, 1, 2]], axis=0)
    spans = np.hypot(sides[:, 0], sides[:, 1])
    # Along the spine goes the steeper side: a label in two lines may be as broad as it is long.
    upright = int(np.argmax(np.abs(sides[:, 1]) / np.maximum(spans, 1e-9)))
    down = sides[upright] / spans[upright] * (1 if sides[upright][1] >= 0 else -1)
    return LabelBox(
        (view.left - float(centre[0]) * view.m_per_px, view.top - float(centre[1]) * view.m_per_px),
        (-float(down[0]), -float(down[1])),
        (float(spans[upright]) + 1) * view.m_per_px,
        (float(spans[1 - upright]) + 1) * view.m_per_px,
    )


def _printed(view: FlatView, box: LabelBox) -> bool:
    """Return whether a label has print on it; a bare band or a paper spine has none."""
    column, row = (view.left - box.centre[0]) / view.m_per_px, (view.top - box.centre[1]) / view.m_per_px
    half_w, half_h = 0.3 * box.width / view.m_per_px, 0.4 * box.length / view.m_per_px
    top, left = max(0, round(row - half_h)), max(0, round(column - half_w))
    inner = view.picture[top : round(row + half_h), left : round(column + half_w)]
    white, black = np.percentile(inner, (95, 2))
    share = float((inner < (white + black) / 2).mean())
    return bool(white - black > 40 and _INK_SHARE[0] < share < _INK_SHARE[1])
