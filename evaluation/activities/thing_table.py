"""Sizes of the things in household activities, by category."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field

from handcart.files.models.loading import load
from handcart.files.models.model import FileModel

TABLE_PATH = Path(__file__).parent / "things.yaml"
Positive = Annotated[float, Field(gt=0.0)]


class CarriedEntry(FileModel):
    """Form, dimensions and mass of the things of a category that a hand can carry; the things are upright."""

    shape: Literal["box", "cylinder"] = "box"
    size_mm: tuple[Positive, Positive, Positive]
    """Size along the thing's x, y and z (upwards); y is its depth on a shelf."""
    mass_kg: Positive
    source: str
    """Origin of the size."""


class FurnitureEntry(FileModel):
    """Size and form of a category of furniture; the front of a piece is its -y side."""

    form: Literal["table", "shelf", "box", "tray", "block", "floor"]
    """A table and a tray carry things on top, a shelf in an opening between boards as well, an open box on
    its bottom, a floor on areas of it; a block carries nothing, and things may be next to it."""
    size_m: tuple[Positive, Positive, Positive]
    """Width, depth and total height."""
    board_m: Positive | None = None
    """Height of the board in a shelf's opening."""
    opening_m: Positive | None = None
    """Free height of that opening."""
    source: str


class ThingTable(FileModel):
    """Table of the categories of carried things and of furniture in activities, with their sizes."""

    format: Literal["handcart-things/1"]
    carried: dict[str, CarriedEntry]
    furniture: dict[str, FurnitureEntry]


@cache
def thing_table() -> ThingTable:
    """Return handcart's table of the categories of things and furniture, with their sizes."""
    return load(TABLE_PATH, ThingTable)
