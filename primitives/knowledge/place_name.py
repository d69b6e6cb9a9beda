"""Parameters that name something of the world model."""

from __future__ import annotations

from typing import Annotated, NamedTuple

from pydantic import Field


class Names(NamedTuple):
    """Mark of a parameter that holds a name of an entry of the world model, so that files can be checked."""

    entry: str


PlaceName = Annotated[str, Field(min_length=1), Names("places")]
"""The name of a place on the map."""
