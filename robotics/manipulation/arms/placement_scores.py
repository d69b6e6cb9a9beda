"""Scores of base placements at the points of a path."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handcart.robotics.manipulation.paths.untrackable import Untrackable
from handcart.robotics.numerics.arrays import BoolArray, IndexArray, SingleArray


class PlacementScores(NamedTuple):
    """Scores of b base poses (placements) at p points of a path: how well the arm can work there.

    Higher is better; a mask marks the base poses from which the arm reaches a point within its limits.

    The arrays are stored in column order: the values of all base poses for one point are contiguous in
    memory.
    """

    values: SingleArray
    """Scores (b, p); 0 where a placement is not usable."""
    usable: BoolArray
    """(b, p): reached, and within the limits of the measure."""
    joined: BoolArray | None = None
    """(b, p-1) True where the arm gets from a point to the next without a jump; None if it always does."""

    def without(self, blocked: BoolArray) -> PlacementScores:
        """Return the scores with placements (base poses) marked as not usable where `blocked` (b,) is
        True.
        """
        return self.restricted(self.usable & ~blocked[:, None])

    def restricted(self, usable: BoolArray) -> PlacementScores:
        """Return the scores with another mask `usable` (b, p); the score is 0 where the mask is False.

        Rows are b base poses, columns p points of the path. The new mask replaces the present one, and has to
        be False wherever the present one is False.
        """
        usable = np.asfortranarray(usable)
        return self._replace(values=np.where(usable, self.values, np.float32(0.0)), usable=usable)

    def only(self, kept: BoolArray | IndexArray) -> PlacementScores:
        """Return the scores of those placements (base poses) that `kept` selects.

        Args:
            kept: mask (b,), or numbers (k,) of the placements.
        """
        joined = None if self.joined is None else np.asfortranarray(self.joined[kept])
        return PlacementScores(
            np.asfortranarray(self.values[kept]), np.asfortranarray(self.usable[kept]), joined
        )

    def also(self, more: PlacementScores) -> PlacementScores:
        """Return scores of both sets of placements (base poses): those of `self`, followed by those of
        `more`.
        """
        joined = None
        if self.joined is not None and more.joined is not None:
            joined = np.asfortranarray(np.vstack((self.joined, more.joined)))
        return PlacementScores(
            np.asfortranarray(np.vstack((self.values, more.values))),
            np.asfortranarray(np.vstack((self.usable, more.usable))),
            joined,
        )

    def check(self) -> None:
        """Raise `Untrackable` for the path's first point that the arm can track from none of the placements
        (poses of the base).
        """
        served = self.usable.any(axis=0)
        if not served.all():
            index = int(np.argmin(served))
            raise Untrackable(index, "can't be tracked from any of the placements")
