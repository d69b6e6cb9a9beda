"""Where sensors go."""

from __future__ import annotations

from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from handcart.primitives.knowledge.place_name import Names
from handcart.robotics.geometry.pose2 import Pose2

TargetName = Annotated[str, Field(min_length=1), Names("targets")]
"""The name of a target in the field."""


class Target(NamedTuple):
    """A place on the ground where a sensor is to be laid."""

    name: str
    x: float
    """East of the field's origin, in [m]."""
    y: float
    """North of it."""
    stand: Pose2
    """world_T_base from which it is laid: the target is to the right."""
    line: int = 0
    """Of the file that told it."""
    column: int = 0


class Laid(NamedTuple):
    """A sensor that was let go."""

    name: str
    x: float
    """Where the robot believes that it lies, in [m]."""
    y: float
    covariance: tuple[float, float, float]
    """Of x, of x with y, of y, in [m²]."""
    beside: tuple[float, float]
    """From the base to it, along the base's heading and to the left of that, level, in [m]."""
    time: float
    """In [s]."""

    @property
    def spread(self) -> NDArray[np.float64]:
        """(2, 2) covariance in [m²]."""
        xx, xy, yy = self.covariance
        return np.array([[xx, xy], [xy, yy]])
