"""Specification of radio beacons in a robot's file or a log's header."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from handcart.files.models.model import FileModel

Positive = Annotated[float, Field(gt=0.0)]
NotNegative = Annotated[float, Field(ge=0.0)]
BeaconPlace = tuple[float, float, float]
"""x, y of a world, height above the ground."""


class BeaconsSpec(FileModel):
    """Radio beacons at fixed places, and the robot's own radio, which measures its distance to each."""

    places_m: Annotated[dict[str, BeaconPlace], Field(min_length=1)]
    """Place of each beacon by name; three or more that are not in one line determine a position."""
    tag_m: BeaconPlace = (0.0, 0.0, 1.0)
    """Place of the robot's own radio in the base frame."""
    period_s: Positive = 0.2
    """Between measurements, each of all beacons."""
    reach_m: Positive = 60.0
    """Beyond which a beacon isn't heard."""
    sigma_m: NotNegative = 0.1
    """Standard deviation of a range."""
    bias_m: NotNegative = 0.3
    """Standard deviation of the offset that all ranges to one beacon share."""
    scale_percent: NotNegative = 1.0
    """Standard deviation of the scale error that all ranges to all beacons share."""
    bias_walk_m_rt_s: NotNegative = 0.01
    """Random walk of the offset that the robot's filter assumes: standard deviation after one second, growing
    with the square root of time. The random walk that is simulated is set in the world's file.
    """
