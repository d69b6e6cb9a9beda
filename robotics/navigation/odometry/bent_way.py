"""Second-order effects of a heading's error on the error of a position.

To first order, an error of the heading moves a base sideways. The cosine of the error shortens the way as
well, and slip that adds to a heading which is wrong already moves the base in another direction than the
estimate says. Each effect is small for a step, but lasts for the drive, and to first order there
is hardly any error along the way: after 30 m, errors were 40 times their claimed variance. The second moments
of these effects are summed up here.
"""

from __future__ import annotations

import math
from functools import cached_property
from typing import NamedTuple, Self

import numpy as np

from handcart.robotics.numerics.arrays import FloatArray

SMALL_VARIANCE = 1e-2  # [rad²] of a heading, below which the first term of a series is exact enough
MAX_CROSSED_VARIANCE = 1.0  # [rad²] of a heading, beyond which slip goes in any direction anyway


class _BentSums(NamedTuple):
    """Fields of a `BentWay`."""

    rest: FloatArray
    """(2, 2) root mean squares of the position's error in [m]: by 1 - cos(e), and by e - sin(e), in rows."""
    crossed: FloatArray
    """(3, 3) covariance of the heading's slip times its error, in [rad²], and of x and y by it, in [m]."""


class BentWay(_BentSums):
    """Position error of odometry that is of second order in the heading's error, summed up over a drive.

    To first order an error of the heading moves the base sideways only. To second order it also shortens the
    travel along the estimated heading, and further slip then moves the base in another direction than
    estimated.
    """

    @classmethod
    def straight(cls) -> Self:
        """Return position errors of zero, for the beginning of a drive."""
        return cls(np.zeros((2, 2)), np.zeros((3, 3)))

    @cached_property
    def covariance(self) -> FloatArray:
        """Covariance (2, 2) of x, y on the map by second-order effects of the heading's error, in [m²]."""
        return np.asarray(self.rest.T @ self.rest + self.crossed[1:, 1:])

    def stepped(self, x: float, y: float, variance: float, slip: float) -> Self:
        """Return these sums after one more step of the base; `covariance` is their effect on the position.

        Args:
            x: x of the base's step on the map, in [m].
            y: y of the base's step on the map, in [m].
            variance: mean variance of the heading during the step, in [rad²].
            slip: part of the variance that this step has added, in [rad²].
        """
        along, aside = rest_sigmas(variance)
        rest = self.rest + np.array([[along * x, along * y], [-aside * y, aside * x]])
        step = np.array([[1.0, 0.0, 0.0], [x, 1.0, 0.0], [y, 0.0, 1.0]])
        crossed = step @ self.crossed @ step.T
        crossed[0, 0] += slip * min(variance, MAX_CROSSED_VARIANCE)
        return type(self)(rest, crossed)

    def corrected(self, kept: FloatArray) -> Self:
        """Return the position errors that remain after the pose was corrected by a measurement.

        Args:
            kept: (3, 3) matrix that maps the error of x, y on the map in [m] and heading in [rad] before the
                correction to the error that remains.
        """
        still = np.zeros((3, 3))
        still[0, 0], still[1:, 1:] = kept[2, 2], kept[:2, :2]
        return type(self)(self.rest @ kept[:2, :2].T, still @ self.crossed @ still.T)


def rest_sigmas(variance: float) -> tuple[float, float]:
    """Return the root mean squares of 1 - cos(e) and of e - sin(e) for normal errors e of a heading.

    Compared with the result to first order in e, a step of 1 m is shorter by the first value, and goes less
    to the side by the second value.

    Args:
        variance: variance of e, in [rad²].
    """
    if variance < SMALL_VARIANCE:
        return math.sqrt(0.75) * variance, math.sqrt(15.0 / 36.0) * max(0.0, variance) ** 1.5
    once, twice = math.exp(-0.5 * variance), math.exp(-2.0 * variance)
    along = 1.5 - 2.0 * once + 0.5 * twice
    aside = variance - 2.0 * variance * once + 0.5 * (1.0 - twice)
    return math.sqrt(along), math.sqrt(aside)
