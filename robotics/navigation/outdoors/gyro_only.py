"""Localization by wheels and gyros alone, without GNSS."""

from __future__ import annotations

from typing import ClassVar

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.outdoors.field_noise import FieldNoise
from handcart.robotics.navigation.outdoors.gps_filter import GpsFilter
from handcart.robotics.navigation.outdoors.noise_hypotheses import NoiseHypothesis
from handcart.robotics.numerics.arrays import FloatArray


class GyroOnly(GpsFilter):
    """Localizer by wheels and gyros alone, as in Ohki et al. (2012), with a covariance; it ignores GNSS
    fixes.
    """

    TAKES_FIXES: ClassVar = False

    def __init__(self, start: Pose2, noise: FieldNoise, start_position: float) -> None:
        """Start with `noise` as the only hypothesis, because without fixes all are alike.

        Args:
            start: world_T_base.
            noise: noise model of wheels and gyros.
            start_position: sigma of the start's position along each axis, in [m].
        """
        super().__init__(start, noise, start_position, supposed=[NoiseHypothesis(noise, 1.0, 0)])

    def _fix(self, position: FloatArray, sigma: float | None) -> bool:
        return False
