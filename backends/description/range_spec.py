"""Lidar in a robot's file."""

from __future__ import annotations

from typing import Annotated, Literal, Self

import numpy as np
from pydantic import AliasChoices, Field, model_validator
from typing_extensions import override

from handcart.robotics.numerics.arrays import BoolArray, FloatArray

from .sensor_spec import MountedSensorSpec

Positive = Annotated[float, Field(gt=0.0)]
NotNegative = Annotated[float, Field(ge=0.0)]
Angle = Annotated[float, Field(ge=-360.0, le=360.0)]

FULL_TURN = 360.0
ROUNDING_DEG = 1e-6  # [deg]
MASK_ROUNDING_DEG = 1e-3  # [deg] by which a beam may miss the end of its masked sector, as in float32


class RangeSpec(MountedSensorSpec):
    """Beams, range, excluded sectors and noise of a lidar whose scanning plane is parallel to the floor."""

    kind: Literal["lidar"] = "lidar"

    beams: Annotated[int, Field(gt=2)]
    """Number of beams of a scan, evenly spread from `start_deg` to `end_deg`."""
    reach_m: Positive = Field(validation_alias=AliasChoices("reach_m", "range_max_m"))
    """Maximum range, in files also called `range_max_m`. A larger reading means no return."""
    range_min_m: NotNegative = 0.0
    """Minimum range; a nearer reading means that something is too close."""
    start_deg: Angle = -180.0
    """Angle of the first beam, counter-clockwise from the frame's x axis."""
    end_deg: Angle = 180.0
    """Angle of the last beam, counter-clockwise from the frame's x axis; in a full turn it equals
    `start_deg`, and that beam is omitted.
    """
    masked_deg: tuple[tuple[Angle, Angle], ...] = ()
    """Sectors in which the lidar sees the robot itself, each as (from, to), counter-clockwise; their readings
    are ignored.
    """
    no_return: tuple[Literal["zero", "below_min", "nan"], ...] = ("zero",)
    """Values that this driver delivers without a return, in addition to infinity and ranges beyond
    `reach_m`.
    """
    sigma_mm: NotNegative
    """Sigma of a range's noise."""

    @model_validator(mode="after")
    def _fits(self) -> Self:
        if self.range_min_m >= self.reach_m:
            raise ValueError(
                f"range_min_m {self.range_min_m:g}; allowed: less than {self.reach_m:g}, the reach"
            )
        if not 0.0 < self.end_deg - self.start_deg <= FULL_TURN + ROUNDING_DEG:
            turn = self.end_deg - self.start_deg
            raise ValueError(f"from start_deg to end_deg {turn:g} degrees; allowed: more than 0, up to 360")
        return self

    @property
    def is_full_turn(self) -> bool:
        """True if the field of view is a full turn."""
        return self.end_deg - self.start_deg > FULL_TURN - ROUNDING_DEG

    @override
    def without_errors(self) -> Self:
        return self.model_copy(update={"sigma_mm": 0.0})

    def angles(self) -> FloatArray:
        """Angles (beams,) of the beams in the sensor's frame, in [rad], counter-clockwise."""
        start, end = np.radians([self.start_deg, self.end_deg])
        return np.linspace(start, end, self.beams, endpoint=not self.is_full_turn)

    def masked(self, angles: FloatArray) -> BoolArray:
        """Return a mask (n,), True for beams whose angles (n,), in [rad], are in a sector that the robot's
        file excludes (`masked_deg`), its ends included.
        """
        found = np.zeros(len(angles), np.bool_)
        degrees = np.degrees(angles)
        for start, end in self.masked_deg:
            wide = FULL_TURN if end - start >= FULL_TURN else (end - start) % FULL_TURN
            after = np.mod(degrees - start + MASK_ROUNDING_DEG, FULL_TURN)
            found |= after <= wide + 2.0 * MASK_ROUNDING_DEG
        return found
