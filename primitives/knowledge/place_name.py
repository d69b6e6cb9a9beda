"""Parameters that name something of the world model."""

from __future__ import annotations

from typing import Annotated, NamedTuple

from pydantic import Field


class Names(NamedTuple):
    """Annotation of a primitive's parameter whose value is a name in an entry of the world model.

    `entry` is that entry; with "places", for example, the value must be a place's name. The reader of task
    files uses this annotation to check the names in them.
    """

    entry: str


PlaceName = Annotated[str, Field(min_length=1), Names("places")]
"""The name of a place on the map."""
