"""Pictures of the labels that a library prints, to compare what is seen with."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from handcart.robotics.numerics.arrays import ByteArray
from handcart.robotics.perception.books.call_number import CallNumber

PX_PER_M = 8000.0
FONT_FILE = "DejaVuSans.ttf"  # of the library's label printer
CAP_HEIGHT, WIDTH, MARGIN = 0.005, 0.010, 0.0025  # [m]: of capitals, of the label, before and after the text
WORD_SPACE_RATIO = 0.45  # between words, in heights of a capital
PAPER, INK = 244, 22


def label_templates(numbers: Iterable[CallNumber]) -> dict[CallNumber, ByteArray]:
    """Return a drawn picture (h, w) of each call number's label, in grey levels, with upright text.

    The pictures have `PX_PER_M` pixels a metre.
    """
    import matplotlib  # for its fonts alone; takes as long to import as the rest of a task's check

    path = Path(matplotlib.get_data_path()) / "fonts" / "ttf" / FONT_FILE
    cap = CAP_HEIGHT * PX_PER_M
    top, bottom = (ImageFont.truetype(str(path), 200).getbbox("H", anchor="ls")[i] for i in (1, 3))
    face = ImageFont.truetype(str(path), 200 * cap / (bottom - top))
    return {number: _label(str(number), face, cap) for number in numbers}


def _label(text: str, face: ImageFont.FreeTypeFont, cap: float) -> ByteArray:
    words = text.split(" ")
    widths = [face.getlength(word) for word in words]
    margin, height = MARGIN * PX_PER_M, round(WIDTH * PX_PER_M)
    length = sum(widths) + WORD_SPACE_RATIO * cap * (len(words) - 1) + 2 * margin
    page = Image.new("L", (round(length), height), PAPER)
    pen, x = ImageDraw.Draw(page), margin
    for word, width in zip(words, widths, strict=True):
        pen.text((x, (height + cap) / 2), word, font=face, fill=INK, anchor="ls")
        x += width + WORD_SPACE_RATIO * cap
    return np.asarray(page, dtype=np.uint8).copy()
