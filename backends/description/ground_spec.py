"""Open ground, and a satellite receiver above it."""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal, Self

from pydantic import Field
from typing_extensions import override

from handcart.files.models.model import FileModel

from .sensor_spec import MountedSensorSpec

Positive = Annotated[float, Field(gt=0.0)]
NotNegative = Annotated[float, Field(ge=0.0)]

OUTDOOR_LOCALIZERS = ("gyro", "particle", "gps_filter", "beacons")
"""Names of the outdoor localizers in a robot's file."""


class GroundSpec(FileModel):
    """Model of rough ground by standard deviations (sigmas) of tilt, wheel slip and side slip.

    A world's file states the true values, a robot's file the assumed ones. With the defaults, the simulated
    field test of Ohki et al. (2012) reproduces the published results
    (`handcart.robotics.navigation.outdoors.field_noise.REFERENCE_NOISE`).
    """

    roughness_deg: NotNegative = 2.5
    """Sigma of roll and pitch of the base."""
    roughness_length_m: Positive = 0.4
    """Distance over which roll and pitch change."""
    softness_mm_per_100n: Annotated[float, Field(ge=0.0, le=50.0)] = 0.0
    """Elastic deflection under each 100 N at each contact point of a wheel; 0: rigid.

    A wheel has two to four contact points (the grid is 5 cm wide), so it sinks in by a half to a quarter
    of that. Used in a world's file, only in physics.
    """
    scale_percent: NotNegative = 0.2 * math.sqrt(2.0)
    """Scale error of the wheels' travel, constant for a day."""
    slip_percent: NotNegative = 0.4
    """Slip in percent of the wheels' travel, drawn again every `slip_length_m`."""
    slip_length_m: Positive = 2.0
    turn_slip_percent: NotNegative = 12.0
    """Slip in percent of the wheels' travel in a curve of 0.5 / m, in proportion to curvature, drawn again
    when the base sets out.
    """
    side_slip_deg: NotNegative = 0.8
    """Sigma of the angle between travel and heading, drawn again every `side_slip_length_m`."""
    side_slip_length_m: Positive = 3.0
    side_slip_deg_m: float = math.degrees(0.02)
    """Side slip angle in a curve, in [deg] for each 1/m of curvature: a known effect, not an error."""


class GpsSpec(MountedSensorSpec):
    """Description of a satellite receiver and the errors of its fixes; its frame in the URDF is at the
    antenna.
    """

    kind: Literal["gps"] = "gps"

    period_s: Positive = 1.0
    """Time between two fixes."""
    white_m: NotNegative = 1.0
    """Sigma of the white error of each fix, on each axis."""
    drift_m: NotNegative = 0.0
    """Sigma of the slow error of the fixes, on each axis (Gauss-Markov)."""
    drift_time_s: Positive = 300.0
    """Time over which the slow error changes."""
    start_heading_deg: NotNegative | Literal["unknown"] = 1.0
    """Sigma of the given start heading, or `unknown` (see ORIENT)."""

    @override
    def without_errors(self) -> Self:
        heading: dict[str, Any] = {}
        if self.start_heading_deg == "unknown":  # a condition of the start, not an error of the sensor
            heading["start_heading_deg"] = "unknown"
        return type(self)(frame=self.frame, period_s=self.period_s, white_m=0.0, **heading)
