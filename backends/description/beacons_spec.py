"""What a robot's file, or a log's header, says of radio beacons."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from handcart.files.models.model import FileModel

Positive = Annotated[float, Field(gt=0.0)]
NotNegative = Annotated[float, Field(ge=0.0)]
BeaconPlace = tuple[float, float, float]
"""x, y of a world, height above the ground."""


class BeaconsSpec(FileModel):
    """Radio beacons that stand about, and the robot's own radio, which measures how far they are."""

    places_m: Annotated[dict[str, BeaconPlace], Field(min_length=1)]
    """Where each stands, by its name; three or more not in one line tell a place."""
    tag_m: BeaconPlace = (0.0, 0.0, 1.0)
    """Of the robot's own radio in the base frame."""
    period_s: Positive = 0.2
    """Between measurements, each of all beacons."""
    reach_m: Positive = 60.0
    """Beyond which a beacon isn't heard."""
    sigma_m: NotNegative = 0.1
    """Of a range."""
    bias_m: NotNegative = 0.3
    """By which all ranges to one beacon are too long or too short: sigma."""
    scale_percent: NotNegative = 1.0
    """By which all ranges are too long or too short, the same of all beacons: sigma."""
    bias_walk_m_rt_s: NotNegative = 0.01
    """By which the robot supposes that this wanders off, after a second; it grows with the square root of
    time. What it does in a simulated world stands in the world's file."""
