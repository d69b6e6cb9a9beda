"""The header of a recorded log in CSV: what its columns are."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import Field

from handcart.backends.description.beacons_spec import BeaconsSpec
from handcart.files.models.model import FileModel

Positive = Annotated[float, Field(gt=0.0, le=1e6)]

UNITS: dict[str, dict[str, float]] = {
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9},
    "rate": {"rad/s": 1.0, "deg/s": math.radians(1.0)},
    "acceleration": {"m/s2": 1.0, "g": 9.80665},
    "length": {"m": 1.0, "mm": 1e-3},
    "speed": {"m/s": 1.0, "mm/s": 1e-3, "km/h": 1.0 / 3.6, "mph": 0.44704},
    "angle": {"rad": 1.0, "deg": math.radians(1.0)},
    "degrees": {"deg": 1.0},
}
"""How many SI units one of each is, by what is measured."""

QUANTITIES: dict[str, tuple[str, ...]] = {
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
"""What a column may hold, and what of that is measured; a wheel's length is its travel since the last row."""


class Column(FileModel):
    """A column of the table."""

    unit: str
    """See docs/how_to/localize.md; SI units, and those in use beside them."""
    name: str | None = None
    """What the table calls it; left out: as the quantity is called."""
    factor: float = 1.0
    """By which its numbers are multiplied first: -1 for an axis that points the other way."""
    held: bool = False
    """The recorder writes the last value again until there is a new one: what repeats tells nothing new."""


class Start(FileModel):
    """Where the base is before the first row; what is left out isn't known."""

    x_m: float | None = None
    y_m: float | None = None
    heading_deg: float | None = None


class LogHeader(FileModel):
    """Stands between two lines `---` at the beginning of a log, before the table."""

    format: Literal["handcart-log/1"]
    columns: Annotated[dict[str, Column], Field(min_length=2)]
    start: Start = Start()
    antenna_m: tuple[float, float, float] | None = None
    """Of the receiver in the base frame; left out: as in the robot's file."""
    tread_m: Positive | None = None
    """Between left and right wheel: needed where there is no vertical gyro."""
    wheelbase_m: Positive | None = None
    """Between front and rear axle: needed for `steering`."""
    beacons: BeaconsSpec | None = None
    """Needed for ranges; as in a robot's file."""

    @property
    def range_columns(self) -> tuple[str, ...]:
        """What columns of ranges are called, in the order of the beacons."""
        return () if self.beacons is None else tuple(f"range_{name}" for name in self.beacons.places_m)

    @property
    def quantities(self) -> dict[str, tuple[str, ...]]:
        """`QUANTITIES`, and a range to each beacon."""
        return dict.fromkeys(self.range_columns, ("length",)) | QUANTITIES
