"""Width of text in drawings."""

from __future__ import annotations

from functools import lru_cache
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING
from unicodedata import east_asian_width

if TYPE_CHECKING:
    from PIL.ImageFont import FreeTypeFont

FONT_FAMILY = "DejaVu Sans"
"""Font that is measured and requested: wider than Helvetica and Arial, its usual substitutes."""
_UNITS = 100  # of a letter's height in which is measured


def text_width(words: str, size: float, *, bold: bool = False) -> float:
    """Return the width of a line of text set in `FONT_FAMILY`, in the unit of `size`."""
    wide = sum(east_asian_width(letter) in "WF" for letter in words)  # not in the font: squares
    narrow = "".join(letter for letter in words if east_asian_width(letter) not in "WF")
    return size * (_font(bold).getlength(narrow) / _UNITS + wide)


@lru_cache
def _font(bold: bool) -> FreeTypeFont:
    from PIL.ImageFont import truetype

    spec = find_spec("matplotlib")  # its font alone: importing it takes ten times as long as a picture
    assert spec is not None and spec.submodule_search_locations is not None
    folder = Path(spec.submodule_search_locations[0]) / "mpl-data/fonts/ttf"
    return truetype(str(folder / f"DejaVuSans{'-Bold' if bold else ''}.ttf"), _UNITS)
