"""Parameters that name something of the world model."""

from __future__ import annotations

from typing import Annotated, NamedTuple

from pydantic import Field


class Names(NamedTuple):
    """Annotation of a primitive's parameter whose value is a name in an entry of the world model.

    Names in task files are checked by it; with `entry` "places", for example, the value is a place's name.
    """

    entry: str


PlaceName = Annotated[str, Field(min_length=1), Names("places")]
"""The name of a place on the map."""
