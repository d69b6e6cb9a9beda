"""Field file of a robot that works outdoors: bounds, rocks, sensors and tolerances."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import Field as Limited

from handcart.files.models.model import FileModel
from handcart.primitives.knowledge.place import DirectedTolerance
from handcart.robotics.geometry.transform import transform
from handcart.robotics.kinematics.shapes import Box
from handcart.robotics.numerics.arrays import FloatArray

Positive = Annotated[float, Limited(gt=0.0)]


class Origin(FileModel):
    """Latitude and longitude of the field's origin on the Earth, in [deg] (WGS 84)."""

    latitude_deg: Annotated[float, Limited(ge=-90.0, le=90.0)]
    longitude_deg: Annotated[float, Limited(ge=-180.0, le=180.0)]


class Rock(FileModel):
    """Known obstacle in the field, described as a disc on the ground by middle and radius."""

    x_m: float
    y_m: float
    radius_m: Positive


class Field(FileModel):
    """Area outdoors with its bounds and known obstacles, in coordinates of its own: x east, y north, in
    [m].
    """

    format: Literal["handcart-field/1"]
    x_m: tuple[float, float]
    """Bounds from west to east."""
    y_m: tuple[float, float]
    """Bounds from south to north."""
    origin: Origin | None = None
    """Position of the origin, needed if targets are given by latitude and longitude."""
    rocks: tuple[Rock, ...] = ()
    """Known obstacles."""
    aside_m: Positive = 0.75
    """Distance from the middle of the rear axle to a target on its right, from which a sensor is laid."""
    stand_tolerance_mm: Positive | DirectedTolerance | None = None
    """Maximum position error of the base at the place for a target, measured with 3 sigma.

    (default: as any place of a car)
    """
    stand_tolerance_deg: Positive | None = None
    """Maximum heading error of the base at the place for a target, measured with 3 sigma."""
    sensor_mm: tuple[Positive, Positive, Positive] = (60.0, 60.0, 120.0)
    """Size of a sensor: along and across the fingers, and its height."""
    gripped_mm: Positive = 35.0
    """Height of the part of a sensor between the fingers."""

    @property
    def discs(self) -> FloatArray:
        """Rocks (n, 3): x, y in the field's frame and radius, in [m]."""
        return np.array([[rock.x_m, rock.y_m, rock.radius_m] for rock in self.rocks]).reshape(-1, 3)

    def holds(self, x: float, y: float) -> bool:
        """Return whether a point, x and y in the field's frame in [m], is inside the field."""
        return self.x_m[0] <= x <= self.x_m[1] and self.y_m[0] <= y <= self.y_m[1]

    def below(self, finger_tip: float) -> float:
        """Return the height of the frame `hand` above the foot of a held sensor, in [m].

        Args:
            finger_tip: distance of the finger tips from the origin of the frame `hand`, in [m].
        """
        return finger_tip + (self.sensor_mm[2] - self.gripped_mm) / 1e3

    def held(self, finger_tip: float, name: str) -> Box:
        """Return the box of a held sensor, posed in the hand's frame, with the sensor's height along x.

        Args:
            finger_tip: distance of the finger tips from the hand's origin, in [m].
            name: name of the box.
        """
        length, width, height = (positive / 1e3 for positive in self.sensor_mm)
        middle = transform((self.below(finger_tip) - height / 2, 0.0, 0.0))
        return Box(middle, (height, width, length), name)
