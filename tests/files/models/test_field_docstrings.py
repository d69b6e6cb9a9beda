"""Docstrings below the fields of models: found with those of base classes, and shown in schemas."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from handcart.files.models.field_docstrings import field_docstrings
from handcart.files.models.json_schema import schema
from handcart.files.models.model import FileModel


class Thing(FileModel):
    """A thing."""

    width_mm: float
    """Width, in [mm]."""
    name: str = ""
    colour: Annotated[str, Field(description="Its colour.")] = "red"
    """Not shown: the field says it."""


class Box(Thing):
    """A box."""

    name: str = "box"
    """Name on its lid."""
    other: float = Field(0.0, alias="height_mm")
    """Height, in [mm]."""


class Bare(Box):
    """A box without a word about its width."""

    width_mm: float


def test_docstrings_are_found_with_those_of_base_classes() -> None:
    assert field_docstrings(Box) == {
        "width_mm": "Width, in [mm].",
        "colour": "Not shown: the field says it.",
        "name": "Name on its lid.",
        "other": "Height, in [mm].",
    }
    assert "width_mm" not in field_docstrings(Bare)


def test_schemas_have_them_as_descriptions() -> None:
    shown = {key: value.get("description") for key, value in schema(Box)["properties"].items()}
    assert shown == {
        "width_mm": "Width, in [mm].",
        "name": "Name on its lid.",
        "colour": "Its colour.",
        "height_mm": "Height, in [mm].",
    }
