"""Header of a recorded log in CSV, which describes its columns."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import Field

from handcart.backends.description.beacons_spec import BeaconsSpec
from handcart.files.models.model import FileModel

Positive = Annotated[float, Field(gt=0.0, le=1e6)]

UNIT_FACTORS: dict[str, dict[str, float]] = {
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9},
    "rate": {"rad/s": 1.0, "deg/s": math.radians(1.0)},
    "acceleration": {"m/s2": 1.0, "g": 9.80665},
    "length": {"m": 1.0, "mm": 1e-3},
    "speed": {"m/s": 1.0, "mm/s": 1e-3, "km/h": 1.0 / 3.6, "mph": 0.44704},
    "angle": {"rad": 1.0, "deg": math.radians(1.0)},
    "degrees": {"deg": 1.0},
}
"""Factors that convert units to SI, by physical dimension and unit."""

COLUMN_QUANTITIES: dict[str, tuple[str, ...]] = {
    "time": ("time",),
    **{f"gyro_{axis}": ("rate",) for axis in "xyz"},
    **{f"accelerometer_{axis}": ("acceleration",) for axis in "xyz"},
    "wheel_left": ("length", "speed"),
    "wheel_right": ("length", "speed"),
    "speed": ("speed",),
    "steering": ("angle",),
    "gps_east": ("length",),
    "gps_north": ("length",),
    "latitude": ("degrees",),
    "longitude": ("degrees",),
    "gps_sigma": ("length",),
    "true_x": ("length",),
    "true_y": ("length",),
    "true_heading": ("angle",),
    "true_latitude": ("degrees",),
    "true_longitude": ("degrees",),
}
"""Quantities that a column may hold, with their physical dimensions; the length of a wheel is its travel
since the previous row.
"""


class Column(FileModel):
    """Column of a log's table, with its title and the conversion of its numbers to SI units."""

    unit: str
    """Unit of the numbers: SI or a common other unit, see docs/how_to/localize.md."""
    name: str | None = None
    """Title of the column in the table (default: the name of the quantity)."""
    factor: float = 1.0
    """Factor applied to the numbers before the unit; -1 for a reversed axis."""
    held: bool = False
    """True if the recorder repeats the last value until there is a new one; repetitions are ignored."""


class LogStart(FileModel):
    """Pose of the base when a log begins, before its first row; omitted values are unknown."""

    x_m: float | None = None
    y_m: float | None = None
    heading_deg: float | None = None


class LogHeader(FileModel):
    """Header, in YAML, of a log in CSV, with columns, start pose and sensors.

    It is between two lines `---` before the table.
    """

    format: Literal["handcart-log/1"]
    columns: Annotated[dict[str, Column], Field(min_length=2)]
    start: LogStart = LogStart()
    antenna_m: tuple[float, float, float] | None = None
    """Position of the receiver's antenna in the base frame (default: as in the robot's file)."""
    tread_m: Positive | None = None
    """Distance between left and right wheel; required without a vertical gyro."""
    wheelbase_m: Positive | None = None
    """Distance between front and rear axle; required for `steering`."""
    beacons: BeaconsSpec | None = None
    """Beacons as in a robot's file; required for ranges."""

    @property
    def range_columns(self) -> tuple[str, ...]:
        """Names of the columns of ranges, in the order of the beacons."""
        return () if self.beacons is None else tuple(f"range_{name}" for name in self.beacons.places_m)

    @property
    def quantities(self) -> dict[str, tuple[str, ...]]:
        """Names of the quantities that a column of the log may hold, each with its allowed kinds of unit.

        The range to each beacon is a quantity of its own.
        """
        return dict.fromkeys(self.range_columns, ("length",)) | COLUMN_QUANTITIES
