"""What a robot that works outdoors is told of the field."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field as Limited

from handcart.files.models.model import FileModel
from handcart.primitives.knowledge.place import DirectedTolerance
from handcart.robotics.geometry.transform import transform
from handcart.robotics.kinematics.shapes import Box

Positive = Annotated[float, Limited(gt=0.0)]


class Origin(FileModel):
    """Where the field's origin lies on the Earth (WGS 84)."""

    latitude_deg: Annotated[float, Limited(ge=-90.0, le=90.0)]
    longitude_deg: Annotated[float, Limited(ge=-180.0, le=180.0)]


class Rock(FileModel):
    """Something that stands in the field, as a disc on the ground."""

    x_m: float
    y_m: float
    radius_m: Positive


class Field(FileModel):
    """A field: x is east, y north, from an origin of its own."""

    format: Literal["handcart-field/1"]
    x_m: tuple[float, float]
    """From west to east."""
    y_m: tuple[float, float]
    """From south to north."""
    origin: Origin | None = None
    """Needed where targets are given by latitude and longitude."""
    rocks: tuple[Rock, ...] = ()
    """What is known to stand there."""
    aside_m: Positive = 0.75
    """From the middle of the base's rear axle to a target on its right, when a sensor is laid."""
    stand_tolerance_mm: Positive | DirectedTolerance | None = None
    """How far the base may be from where it is to stand for a target, measured with 3 sigma.

    (default: as any place of a car)
    """
    stand_tolerance_deg: Positive | None = None
    """The same of its heading."""
    sensor_mm: tuple[Positive, Positive, Positive] = (60.0, 60.0, 120.0)
    """Of a sensor: along and across the fingers, and its height."""
    gripped_mm: Positive = 35.0
    """Of its height, what stands between the fingers."""

    @property
    def discs(self) -> NDArray[np.float64]:
        """(n, 3) x, y, radius of what stands there, in [m]."""
        return np.array([[rock.x_m, rock.y_m, rock.radius_m] for rock in self.rocks]).reshape(-1, 3)

    def holds(self, x: float, y: float) -> bool:
        """Whether a place in [m] lies in the field."""
        return self.x_m[0] <= x <= self.x_m[1] and self.y_m[0] <= y <= self.y_m[1]

    def below(self, finger_tip: float) -> float:
        """From the frame `hand` down to the foot of a sensor that it holds, in [m]."""
        return finger_tip + (self.sensor_mm[2] - self.gripped_mm) / 1e3

    def held(self, finger_tip: float, name: str) -> Box:
        """A sensor in the hand, posed in the hand's frame: its height along x."""
        length, width, height = (each / 1e3 for each in self.sensor_mm)
        middle = transform((self.below(finger_tip) - height / 2, 0.0, 0.0))
        return Box(middle, (height, width, length), name)
