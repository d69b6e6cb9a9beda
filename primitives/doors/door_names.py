"""Names of doors, as parameters of primitives and in worlds."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from handcart.primitives.knowledge.place_name import Names

DoorName = Annotated[str, Field(min_length=1), Names("doors")]
"""The name of a door or drawer in the file of doors."""


def front_in_world(name: str) -> str:
    """Return the name of a door's front in the simulated world and in its contacts."""
    return f"door {name}"


def handle_in_world(name: str) -> str:
    """Return the name of a door's handle in the simulated world and in its contacts."""
    return f"handle {name}"
