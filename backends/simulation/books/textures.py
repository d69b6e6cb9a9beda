"""Print of a spine: cover, title, ArUco tag near the head, call-number label near the foot."""

from __future__ import annotations

import math
from functools import lru_cache
from pathlib import Path

import cv2
import matplotlib
import numpy as np
from PIL import Image, ImageDraw, ImageFont

from handcart.robotics.numerics.arrays import ByteArray, SingleArray
from handcart.robotics.perception.landmarks.tag_family import (
    DEFAULT_FAMILY,
    TagFamily,
    dictionary,
    modules_of,
)

PX_PER_MM = 8
TAG_SIZE_MM = 10.0  # side of the black square
TAG_QUIET_MM = 2.0  # white margin on each side of it
TAG_CENTRE_FROM_HEAD_MM = 14.0
LABEL_WIDTH_MM = 10.0  # across the spine, if nothing else is said
LABEL_LENGTHS_MM = (42.0, 62.0)  # along the spine: cut to the text between these, on a label of that width
LABEL_FROM_FOOT_MM = 10.0  # its lower end above the book's foot
CAP_HEIGHTS = {1: 0.5, 2: 0.32}  # of capitals, by the lines of a label: share of its width

_PAPER, _INK = 244.0, 22.0
_LABEL_MARGIN = 0.25  # before and after the text: share of the label's width
_ROUNDING_MM = 1.2
_TITLE_WORDS = (
    "ALGEBRA",
    "OPTICS",
    "Rivers",
    "Ethics",
    "FIELDS",
    "Motion",
    "Looms",
    "ATLAS",
    "Light",
    "Numbers",
)


def draw_spine(
    width_mm: float,
    height_mm: float,
    colour_grey: int,
    tag_id: int | None = None,
    call_number: str | None = None,
    font: str | Path = "DejaVuSans.ttf",
    px_per_mm: int = PX_PER_MM,
    smear: bool = False,
    seed: int = 0,
    family: TagFamily = DEFAULT_FAMILY,
    label_mm: float = LABEL_WIDTH_MM,
    lines: int = 1,
) -> ByteArray:
    """Return a spine as seen from straight ahead, head at the top: a grey image (height, width).

    Args:
        width_mm: thickness of the book, in [mm].
        height_mm: height of the book, in [mm].
        colour_grey: grey of the cover, 0 to 255.
        tag_id: number of the tag on the spine; None: no tag.
        call_number: text of the label on the spine; None: no label.
        font: path of a TTF, or the name of one of matplotlib's fonts.
        px_per_mm: resolution, in [px/mm].
        smear: True to make the tag unreadable.
        seed: decides the cover's grain, bands and title.
        family: family of the tag.
        label_mm: width of the label, in [mm].
        lines: number of lines on the label, 1 or 2; with 2, each word has a line.

    Raises:
        ValueError: tag or label don't fit the spine.
    """
    tag_room = TAG_SIZE_MM + 2 * TAG_QUIET_MM if tag_id is not None else 0.0
    if width_mm < max(tag_room, label_mm) or height_mm < 2 * LABEL_LENGTHS_MM[1]:
        raise ValueError(f"a spine of {width_mm:g} x {height_mm:g} mm has no room for tag and label")
    rng = np.random.default_rng(seed)
    spine = _cover(width_mm, height_mm, colour_grey, px_per_mm, rng)
    _decorate(spine, height_mm, px_per_mm, rng)
    if tag_id is not None:
        tag = _tag(tag_id, family, px_per_mm)
        tag = _smeared(tag, rng) if smear else tag
        _paste(spine, tag, TAG_CENTRE_FROM_HEAD_MM * px_per_mm)
    if call_number is not None:
        label = draw_label(call_number, font, px_per_mm, label_mm, lines)
        _paste(spine, label, (height_mm - LABEL_FROM_FOOT_MM) * px_per_mm - label.shape[0] / 2)
    _round_edges(spine, px_per_mm)
    return np.clip(np.rint(spine), 0, 255).astype(np.uint8)


def draw_label(
    text: str,
    font: str | Path = "DejaVuSans.ttf",
    px_per_mm: int = PX_PER_MM,
    width_mm: float = LABEL_WIDTH_MM,
    lines: int = 1,
) -> SingleArray:
    """Return the paper label (h, w), grey, with a text turned 90 degrees clockwise: it reads top to bottom.

    Args:
        text: printed on the label.
        font: name of a font of matplotlib, or path of a file.
        px_per_mm: resolution, in [px/mm].
        width_mm: width across the spine, in [mm].
        lines: number of lines, 1 or 2; with 2, each word has a line.

    Raises:
        ValueError: the text is too long for the longest label.
    """
    cap = CAP_HEIGHTS[lines] * width_mm * px_per_mm
    face, page_words = (
        _face(str(font), cap),
        [text.split(" ")] if lines == 1 else [[w] for w in text.split(" ")],
    )
    # Spaces are set by hand: Computer Modern's fonts have no glyph for one.
    space = 0.45 * cap
    totals = [sum(map(face.getlength, words)) + space * (len(words) - 1) for words in page_words]
    needed_mm = max(totals) / px_per_mm + 2 * _LABEL_MARGIN * width_mm
    shortest, longest = (
        length * (width_mm / LABEL_WIDTH_MM if lines == 1 else 1.0) for length in LABEL_LENGTHS_MM
    )
    if needed_mm > longest:
        raise ValueError(f"{text!r} in {font} needs a label of {needed_mm:.0f} mm; {longest:g} is longest")
    shortest = shortest if lines == 1 else width_mm
    height, length = (round(mm * px_per_mm) for mm in (width_mm, max(shortest, needed_mm)))
    page = Image.new("L", (length, height), round(_PAPER))
    pen, gap = ImageDraw.Draw(page), (height - len(page_words) * cap) / (len(page_words) + 1)
    for line, (words, total) in enumerate(zip(page_words, totals, strict=True)):
        x, baseline = (length - total) / 2, (line + 1) * (gap + cap)
        for word in words:
            pen.text((x, baseline), word, font=face, fill=round(_INK), anchor="ls")
            x += face.getlength(word) + space
    return np.rot90(np.asarray(page, dtype=np.float32), -1).copy()


def label_fonts() -> tuple[str, ...]:
    """Return the file names of the fonts for labels that matplotlib ships, in alphabetical order."""
    stems = ("DejaVuSans", "DejaVuSerif", "STIXGeneral", "cmr", "cmb", "cmss", "cmtt")
    found = sorted(path.name for path in _font_folder().glob("*.ttf"))
    return tuple(name for name in found if name.startswith(stems) and "Display" not in name)


def _font_folder() -> Path:
    return Path(matplotlib.get_data_path()) / "fonts" / "ttf"


@lru_cache(maxsize=64)
def _face(font: str, cap_height_px: float) -> ImageFont.FreeTypeFont:
    path = font if Path(font).is_absolute() else str(_font_folder() / font)
    trial = ImageFont.truetype(path, 200)
    _, top, _, bottom = trial.getbbox("H", anchor="ls")
    return ImageFont.truetype(path, 200 * cap_height_px / (bottom - top))


def _cover(
    width_mm: float, height_mm: float, grey: int, px_per_mm: int, rng: np.random.Generator
) -> SingleArray:
    """Return the picture (h, w), grey, of a cloth cover: grain of about 0.5 mm, and slow stains."""
    height, width = round(height_mm * px_per_mm), round(width_mm * px_per_mm)
    grain = rng.normal(0.0, 4.0, (max(2, height // (px_per_mm // 2)), max(2, width // (px_per_mm // 2))))
    stains = rng.normal(0.0, 4.0, (max(2, int(height_mm / 15)), max(2, int(width_mm / 8))))
    cover = np.full((height, width), float(grey), dtype=np.float32)
    for layer, method in ((grain, cv2.INTER_LINEAR), (stains, cv2.INTER_CUBIC)):
        cover += cv2.resize(layer.astype(np.float32), (width, height), interpolation=method)
    return cover


def _decorate(spine: SingleArray, height_mm: float, px_per_mm: int, rng: np.random.Generator) -> None:
    """Draw bands across the spine, and a title along it, between tag and label."""
    grey = float(np.median(spine))
    contrast = 70.0 if grey < 120.0 else -70.0
    free_top, free_bottom = 26.0, height_mm - LABEL_FROM_FOOT_MM - LABEL_LENGTHS_MM[1] - 4.0
    for _ in range(int(rng.integers(0, 4))):
        centre, thick = rng.uniform(free_top, free_bottom), rng.uniform(0.6, 3.0)
        rows = slice(round((centre - thick / 2) * px_per_mm), round((centre + thick / 2) * px_per_mm))
        spine[rows] += np.float32(contrast * rng.uniform(0.3, 0.9))
    title = " ".join(rng.choice(_TITLE_WORDS, size=int(rng.integers(1, 3))))
    room = round((free_bottom - free_top - 4.0) * px_per_mm)
    across = min(spine.shape[1] - min(4 * px_per_mm, spine.shape[1] // 4), 14 * px_per_mm)
    page = Image.new("L", (room, across), 0)
    face = _face("DejaVuSerif-Bold.ttf", across * rng.uniform(0.25, 0.45))
    ImageDraw.Draw(page).text((room / 2, across / 2), title, font=face, fill=255, anchor="mm")
    mask = np.rot90(np.asarray(page, dtype=np.float32), -1) / 255.0
    top, left = round((free_top + 2.0) * px_per_mm), (spine.shape[1] - across) // 2
    spine[top : top + room, left : left + across] += np.float32(contrast) * mask


def _tag(tag_id: int, family: TagFamily, px_per_mm: int) -> SingleArray:
    side, quiet = round(TAG_SIZE_MM * px_per_mm), round(TAG_QUIET_MM * px_per_mm)
    # Its modules may not divide the side: drawn large and averaged down, their edges are exact.
    marker = cv2.aruco.generateImageMarker(dictionary(family), tag_id, modules_of(family) * side).astype(
        np.float32
    )
    square = cv2.resize(marker, (side, side), interpolation=cv2.INTER_AREA)
    ink = _INK + square * ((_PAPER - _INK) / 255.0)
    return cv2.copyMakeBorder(ink, quiet, quiet, quiet, quiet, cv2.BORDER_CONSTANT, value=_PAPER).astype(
        np.float32
    )


def _smeared(tag: SingleArray, rng: np.random.Generator) -> SingleArray:
    """Return the picture (h, w), grey, of a tag whose ink a wet thumb has dragged slantwise across it."""
    side = tag.shape[0]
    drag = np.zeros((side | 1, side | 1), dtype=np.float32)
    reach, angle = side // 3, rng.uniform(0.6, 1.0)
    step = np.array([math.cos(angle), math.sin(angle)]) * reach
    centre = np.array([side // 2, side // 2])
    start, end = (centre - step).astype(int).tolist(), (centre + step).astype(int).tolist()
    cv2.line(drag, start, end, 1.0, max(1, side // 12))
    blurred = cv2.filter2D(tag, -1, drag / drag.sum(), borderType=cv2.BORDER_REPLICATE)
    return blurred.astype(np.float32)


def _paste(spine: SingleArray, patch: SingleArray, centre_row: float) -> None:
    height, width = patch.shape
    top, left = round(centre_row - height / 2), (spine.shape[1] - width) // 2
    spine[top : top + height, left : left + width] = patch


def _round_edges(spine: SingleArray, px_per_mm: int) -> None:
    """Darken both long edges of a spine (h, w), grey, because they turn away from the light."""
    width = spine.shape[1]
    inward = (np.minimum(np.arange(width), np.arange(width)[::-1]) + 0.5) / (_ROUNDING_MM * px_per_mm)
    depth = np.clip(1.0 - inward, 0.0, 1.0)
    spine *= (0.35 + 0.65 * np.sqrt(1.0 - depth**2)).astype(np.float32)
