"""Whether sensors determine a pose as exactly as something needs it, by its covariance in each direction."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from handcart.robotics.geometry.pose2 import Pose2, wrap

SURE = 3.0  # sigmas that have to stay within a tolerance


class PoseNeed(NamedTuple):
    """How exactly something needs a pose."""

    position: float
    """In [m], along any direction."""
    heading: float
    """In [rad]."""


class Undetermined(NamedTuple):
    """A direction in which a pose is not determined as exactly as needed."""

    direction: float | None
    """Of the position on the map, in [rad] from its x axis, -pi/2 to pi/2; None: the heading is meant."""
    size: float
    """Distance from the wanted pose along that direction, and 3 sigma, together, in [m] or [rad]."""
    limit: float
    """What was needed, in [m] or [rad]."""

    @property
    def unit(self) -> str:
        """Of `shown`."""
        return "deg" if self.direction is None else "mm"

    @property
    def shown(self) -> tuple[float, float]:
        """`size` and `limit` in [mm] or [deg]."""
        factor = math.degrees(1.0) if self.direction is None else 1e3
        return self.size * factor, self.limit * factor

    @property
    def words(self) -> str:
        """For people."""
        size, limit = self.shown
        if self.direction is None:
            return f"the heading is not determined: 3 sigma {size:.2f} deg, at most {limit:.2f} deg allowed"
        along = f"along {round(math.degrees(self.direction))} deg on the map"
        return (
            f"the position is not determined {along}: 3 sigma {size:.0f} mm, at most {limit:.0f} mm allowed"
        )


def undetermined(
    covariance: NDArray[np.float64],
    need: PoseNeed,
    off: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> Undetermined | None:
    """Return the direction in which a pose is determined worst, if it is worse than needed; else None.

    Args:
        covariance: (3, 3) of x, y in [m] and heading in [rad].
        need: what 3 sigma, and what it is off already, may come to.
        off: how far the pose is from the wanted one: x, y in [m] and heading in [rad].
    """
    if not np.isfinite(covariance).all():
        return Undetermined(0.0, math.inf, need.position)
    variances, axes = np.linalg.eigh(covariance[:2, :2])
    sizes = np.abs(np.array(off[:2]) @ axes) + SURE * np.sqrt(np.maximum(variances, 0.0))
    worst = int(np.argmax(sizes))
    if sizes[worst] > need.position:
        x, y = axes[:, worst].tolist()
        return Undetermined(math.atan(y / x) if x else 0.5 * math.pi, float(sizes[worst]), need.position)
    turn = abs(off[2]) + SURE * math.sqrt(max(0.0, float(covariance[2, 2])))
    return Undetermined(None, turn, need.heading) if turn > need.heading else None


def difference(pose: Pose2, goal: Pose2) -> tuple[float, float, float]:
    """Return x, y in [m] and heading in [rad] of a pose beyond those of a goal."""
    return pose.x - goal.x, pose.y - goal.y, wrap(pose.theta - goal.theta)
