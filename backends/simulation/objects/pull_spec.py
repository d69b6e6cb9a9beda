"""A person who pulls at the object in the hand, in a world's file."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from handcart.backends.simulation.world.world_file import Seconds
from handcart.files.models.model import FileModel

Direction = Literal["away", "towards", "left", "right", "up", "down"]


class PullSpec(FileModel):
    """One pull of a person at the object in the hand, or a bump, with its begin, force, direction and
    duration.
    """

    at_s: Seconds | None = None
    """Simulated time at which the pull begins."""
    waits_s: Seconds | None = None
    """Instead: how long the hand has held an object out at rest when the pull begins."""
    force_n: Annotated[float, Field(gt=0.0, le=500.0)] = 15.0
    """Force that the pull rises to."""
    sigma_n: Annotated[float, Field(ge=0.0, le=100.0)] = 0.0
    """Standard deviation of that force, drawn once by the seed."""
    direction: Direction = "away"
    """Direction of the pull as the robot sees it; `away` is horizontal, from the middle of its base to the
    hand.
    """
    sigma_deg: Annotated[float, Field(ge=0.0, le=90.0)] = 0.0
    """Standard deviation of the angle between the pull and that direction, drawn once by the seed."""
    ramp_s: Annotated[float, Field(ge=0.0, le=60.0)] = 0.3
    """Time in which the force rises."""
    duration_s: Annotated[float, Field(gt=0.0, le=3600.0)] = 3.0
    """Time after which the person lets go."""
    tremor_n: Annotated[float, Field(ge=0.0, le=50.0)] = 0.0
    """Standard deviation of the force along each axis, drawn for each period."""
    takes: bool = True
    """True if the person has the object once the fingers let it go; False: it falls."""

    @model_validator(mode="after")
    def _begins_once(self) -> Self:
        if (self.at_s is None) == (self.waits_s is None):
            raise ValueError("a pull begins at at_s or after waits_s; allowed: one of them")
        return self
