"""Place of one laid sensor."""

from __future__ import annotations

from typing import NamedTuple

from handcart.primitives.field.target import Laid

Place = tuple[float, float]
"""x and y in the field's frame, in [m]."""


class Placement(NamedTuple):
    """Position of one laid sensor: as wanted (target), as estimated by the robot, as measured, and as it
    truly is.
    """

    name: str
    target: tuple[float, float]
    """Target in the field's frame, in [m]."""
    believed: Laid
    """Robot's estimate when it released the sensor."""
    measured: tuple[float, float] | None
    """Measurement by the total station in the field's frame, in [m]; None if the reflector was out of
    sight.
    """
    lies: tuple[float, float]
    """True position of the sensor in the field's frame, in [m]."""

    @property
    def error_mm(self) -> tuple[float, float] | None:
        """Measured less desired position of the sensor, x and y in the field's frame in [mm]; None if it was
        not measured.
        """
        if self.measured is None:
            return None
        return 1e3 * (self.measured[0] - self.target[0]), 1e3 * (self.measured[1] - self.target[1])
