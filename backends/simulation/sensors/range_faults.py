"""Readings that a lidar's driver delivers now and then, instead of a range."""

from __future__ import annotations

from typing import NamedTuple, Self

import numpy as np

from handcart.backends.description.simulated_errors import Errors
from handcart.robotics.numerics.arrays import FloatArray

OWN_BODY_M = 0.12
"""Range of a return of the robot's own body, in [m]."""


class RangeFaults(NamedTuple):
    """Shares of a lidar's beams, 0 to 1, that have a faulty reading, by kind of fault.

    In each period, the faulty beams are drawn at random, independently for each beam.
    """

    zero: float = 0.0
    nan: float = 0.0
    too_close: float = 0.0
    """Share of beams that read -infinity, as if something were too close."""
    own_body: float = 0.0

    @classmethod
    def of(cls, errors: Errors) -> Self:
        """Convert the percentages of faulty beams in `errors`, a section of a robot's file, to shares from 0
        to 1.
        """
        percents = (
            errors.range_zero_percent,
            errors.range_nan_percent,
            errors.range_too_close_percent,
            errors.range_own_body_percent,
        )
        return cls(*(percent / 100.0 for percent in percents))

    @property
    def any(self) -> bool:
        """True if the readings of any beams are to be faulty (a share is above 0)."""
        return max(self) > 0.0

    def spoil(self, ranges: FloatArray, rng: np.random.Generator) -> FloatArray:
        """Return the ranges (n,) of one lidar scan, in [m], with random faults added.

        Args:
            ranges: (n,) true ranges, in [m].
            rng: source of the faults.
        """
        draws = rng.random((len(self), len(ranges)))
        spoiled = ranges.copy()
        readings = (0.0, np.nan, -np.inf, OWN_BODY_M)
        for reading, share, draw in zip(readings, self, draws, strict=True):
            spoiled[draw < share] = reading
        return spoiled


NO_FAULTS = RangeFaults()
