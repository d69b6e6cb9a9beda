"""Names of objects and surfaces, as parameters of primitives."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from handcart.primitives.knowledge.place_name import Names

ObjectName = Annotated[str, Field(min_length=1), Names("objects")]
"""The name of an object in the file of objects."""
SurfaceName = Annotated[str, Field(min_length=1), Names("surfaces")]
"""The name of a surface in the file of objects."""
SpotName = Annotated[str, Field(min_length=1), Names("spots")]
"""The name of a spot of a surface in the file of objects."""


def name_in_world(name: str) -> str:
    """Return the name of an object's body in the simulated world and in the contacts reported there."""
    return f"object {name}"
