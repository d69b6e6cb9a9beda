"""Errors of ranges to radio beacons."""

from __future__ import annotations

from typing import NamedTuple

from handcart.robotics.numerics.arrays import FloatArray


class BeaconErrors(NamedTuple):
    """Known positions of radio beacons and of the robot's radio, and standard deviations of measured
    ranges.
    """

    places: FloatArray
    """(k, 3) of the beacons: world's x, y, and height above the ground, in [m]."""
    tag: tuple[float, float, float]
    """Position of the robot's own radio in the base frame, in [m]."""
    white: float = 0.1
    """White noise of each range (sigma), in [m]."""
    bias: float = 0.3
    """Sigma of each beacon's own constant range error, in [m]."""
    scale: float = 0.01
    """Sigma of the relative range error that all beacons share."""
    bias_walk: float = 0.01
    """Random walk of a bias, in [m/√s]; with 0, covariances are far too small if a bias is not constant."""
