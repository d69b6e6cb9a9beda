"""What a calibration found of the robot itself."""

from __future__ import annotations

from typing import NamedTuple


class Calibrated(NamedTuple):
    """A value of the robot's file, as it was measured; its unit is in the key."""

    value: float | tuple[float, ...]
    sigma: float | tuple[float, ...]
    """Standard deviation of each number."""
