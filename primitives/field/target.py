"""Targets of sensors, and the sensors that were laid."""

from __future__ import annotations

from typing import Annotated, NamedTuple

import numpy as np
from pydantic import Field

from handcart.primitives.knowledge.place_name import Names
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.numerics.arrays import FloatArray

TargetName = Annotated[str, Field(min_length=1), Names("targets")]
"""The name of a target in the field."""


class Target(NamedTuple):
    """Point on the ground where a sensor is to be laid, in the field's frame, and the pose of the base for
    it.
    """

    name: str
    x: float
    """East of the field's origin, in [m]."""
    y: float
    """North of the field's origin, in [m]."""
    stand: Pose2
    """world_T_base from which the sensor is laid, with the target to the right."""
    line: int = 0
    """Line of the target in its file."""
    column: int = 0


class Laid(NamedTuple):
    """Sensor that was released on the ground, with its estimated position in the field's frame and
    covariance.
    """

    name: str
    x: float
    """x of the sensor's believed position, in [m]."""
    y: float
    covariance: tuple[float, float, float]
    """Variance of x, covariance of x and y, variance of y, in [m²]."""
    beside: tuple[float, float]
    """Position relative to the base, level, along its heading and to the left of it, in [m]."""
    time: float
    """Time of the release, in [s]."""

    @property
    def spread(self) -> FloatArray:
        """Covariance (2, 2) of the laid sensor's position x, y in the field's frame, in [m²]."""
        xx, xy, yy = self.covariance
        return np.array([[xx, xy], [xy, yy]])
