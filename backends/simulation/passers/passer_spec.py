"""Section `passers` of a world's file: people and carts that walk along waypoints."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from handcart.files.models.model import FileModel

Coordinate = Annotated[float, Field(ge=-1e7, le=1e7)]
Point = tuple[Coordinate, Coordinate]
MAX_WAYPOINTS = 200
MAX_COMPANIONS = 20


class PasserSpec(FileModel):
    """A person or a cart that walks along waypoints, alone or as a group side by side."""

    name: Annotated[str, Field(min_length=1, max_length=60)]
    waypoints_m: Annotated[tuple[Point, ...], Field(min_length=1, max_length=MAX_WAYPOINTS)]
    """Points on the floor, walked to in straight lines. One point: the passer stays there."""
    speed_m_s: Annotated[float, Field(gt=0.0, le=5.0)] = 1.2
    speed_sigma_percent: Annotated[float, Field(ge=0.0, le=30.0)] = 0.0
    """Standard deviation of the speed, drawn once for a seed."""
    radius_m: Annotated[float, Field(ge=0.05, le=1.5)] = 0.25
    """Radius of the body."""
    body: Literal["legs", "disc"] = "legs"
    """Shape that a low lidar sees: two legs that swing, or the disc of the body, as of a cart."""
    pauses_s: Annotated[tuple[Annotated[float, Field(ge=0.0, le=3600.0)], ...], Field(max_length=200)] = ()
    """Pause at each waypoint (default: none)."""
    at_end: Literal["turn_back", "loop", "stay"] = "turn_back"
    """Behaviour after the last waypoint: walk back, walk to the first one and repeat, or stay."""
    starts_s: Annotated[float, Field(ge=0.0)] = 0.0
    """Simulated time at which it leaves the first waypoint."""
    group_m: Annotated[
        tuple[Annotated[float, Field(ge=-10.0, le=10.0)], ...], Field(max_length=MAX_COMPANIONS)
    ] = ()
    """Companions: distance of each to the left of the path, negative to the right."""
    yields: bool = False
    """True to wait while the robot is near and ahead; by default it walks on and ignores the robot."""
    yields_m: Annotated[float, Field(ge=0.0, le=10.0)] = 0.6
    """Distance between both bodies below which it yields."""

    @model_validator(mode="after")
    def _can_be_walked(self) -> Self:
        if self.pauses_s and len(self.pauses_s) != len(self.waypoints_m):
            wrong = f"{len(self.pauses_s)} pauses_s for {len(self.waypoints_m)} waypoints_m"
            raise ValueError(f"{wrong}; allowed: one for each, or none")
        around = [*self.waypoints_m, *(self.waypoints_m[:1] if self.at_end == "loop" else ())]
        if len(self.waypoints_m) > 1 and any(a == b for a, b in pairwise(around)):
            raise ValueError("two waypoints in a row are the same; allowed: different ones, and pauses_s")
        if self.at_end == "loop" and len(self.waypoints_m) < 2:
            raise ValueError("a loop through one waypoint; allowed: two at least, or at_end: stay")
        return self

    @property
    def members(self) -> tuple[str, ...]:
        """Names of all members of a group that walks together, which are the passer that the file describes
        and its companions.
        """
        return (self.name, *(f"{self.name} {number}" for number in range(2, len(self.group_m) + 2)))
