"""Test whether a pose is determined within a need, by its covariance in each direction."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from handcart.robotics.geometry.pose2 import Pose2, wrap
from handcart.robotics.numerics.arrays import FloatArray
from handcart.robotics.numerics.kept_limits import uniform_limits

from .pose_covariance import SCAN_REPEATABILITY

NO_SHIFT = np.zeros(2)
DETERMINED_SIGMAS = 3.0  # sigmas that have to stay within a tolerance
_ANGLES = np.linspace(0.0, math.pi, 24, endpoint=False)
EVEN_DIRECTIONS = np.vstack([np.cos(_ANGLES), np.sin(_ANGLES)])
"""Unit vectors (2, 24) in columns: with a shift, the worst direction is not a principal axis."""
MIN_DIRECTION_X = 1e-9  # x of a unit vector, below which it points along y


class PoseNeed(NamedTuple):
    """Required accuracy of a pose, in position and heading."""

    position: float
    """Limit of the position's error in [m] along any direction; only along `axis` if `across` is given."""
    heading: float
    """Limit of the heading's error, in [rad]."""
    across: float | None = None
    """Limit in [m] perpendicular to `axis`; None: `position` holds in all directions."""
    axis: float = 0.0
    """Direction on the map, in [rad], counter-clockwise from its x axis."""

    @property
    def strictest(self) -> float:
        """Smallest of the limits of the position's error over all directions, in [m]."""
        return self.position if self.across is None else min(self.position, self.across)

    def scaled(self, share: float) -> PoseNeed:
        """Return a copy of the required accuracy in which all limits of errors are multiplied by `share`."""
        across = None if self.across is None else share * self.across
        return PoseNeed(share * self.position, share * self.heading, across, self.axis)

    def axes(self, covariance: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the two directions along which a position's error is checked, and the limit in each.

        Args:
            covariance: (2, 2) or (3, 3) covariance of the pose on the map, of x and y in [m²] first.

        Returns:
            (2, 2) unit vectors on the map in columns, and (2,) limits in [m]. If `across` is None, the
            directions are the principal axes of the covariance, along one of which the error is largest;
            otherwise, they are `axis` and the direction perpendicular to it.
        """
        if self.across is None:
            return np.linalg.eigh(covariance[:2, :2])[1], np.full(2, self.position)
        cos, sin = math.cos(self.axis), math.sin(self.axis)
        return np.array([[cos, -sin], [sin, cos]]), np.array([self.position, self.across])


class Undetermined(NamedTuple):
    """The direction in which a pose is too uncertain, and by how much, after a failed accuracy check."""

    direction: float | None
    """Direction of the position on the map, in [rad] from its x axis, -pi/2 to pi/2; None: the heading."""
    size: float
    """Sum of the distance from the wanted pose along that direction, and 3 sigma, in [m] or [rad]."""
    limit: float
    """Required limit, in [m] or [rad]."""

    @property
    def unit(self) -> str:
        """Unit of the values for messages (`shown`): "deg" for the heading, "mm" for the position."""
        return "deg" if self.direction is None else "mm"

    @property
    def shown(self) -> tuple[float, float]:
        """The values `size` and `limit` for messages, in [mm] for the position or [deg] for the heading."""
        factor = math.degrees(1.0) if self.direction is None else 1e3
        return self.size * factor, self.limit * factor

    @property
    def words(self) -> str:
        """Message that names the direction in which the pose is too uncertain, its uncertainty there, and the
        largest allowed one.
        """
        size, limit = self.shown
        digits = (0 if limit >= 10.0 and self.unit == "mm" else 2) if limit >= 0.1 else 4
        sizes = f"3 sigma {size:.{digits}f} {self.unit}, at most {limit:.{digits}f} {self.unit} allowed"
        if self.direction is None:
            return f"the heading is not determined: {sizes}"
        along = f"along {round(math.degrees(self.direction))} deg on the map"
        return f"the position is not determined {along}: {sizes}"


def undetermined(
    covariance: FloatArray,
    need: PoseNeed,
    off: tuple[float, float, float] = (0.0, 0.0, 0.0),
    shift: FloatArray = NO_SHIFT,
) -> Undetermined | None:
    """Return the direction in which a pose is least accurate; None if the pose is accurate enough for `need`.

    Args:
        covariance: (3, 3) covariance of the pose: x and y on the map in [m], heading in [rad].
        need: required accuracy; the error compared with it is 3 sigma plus the distance from the wanted pose.
        off: pose minus the wanted pose: x, y on the map in [m] and heading in [rad].
        shift: largest systematic error of the position on the map, either way, in [m], in addition to the
            covariance; (2,) for a single error, or (1 + n, 2) with n further, independent errors; the larger
            of the single error and their sum is used (see `depth_shifts`). A systematic error is the same in
            all readings at one place.
    """
    if not np.isfinite(covariance).all():
        return Undetermined(0.0, math.inf, need.position)
    axes, limits = need.axes(covariance)
    alike = np.atleast_2d(shift)[0]
    if need.across is None and (length := math.hypot(*alike.tolist())) > 0.0:
        axes = np.column_stack([axes, alike / length, EVEN_DIRECTIONS])
        limits = np.full(axes.shape[1], need.position)
    spread = _reach(covariance, axes, shift)
    sizes = np.abs(np.array(off[:2]) @ axes) + spread
    worst = int(np.argmax(sizes / limits))
    if sizes[worst] > limits[worst]:
        x, y = axes[:, worst].tolist()
        direction = math.atan(y / x) if abs(x) > MIN_DIRECTION_X else 0.5 * math.pi
        return Undetermined(direction, float(sizes[worst]), float(limits[worst]))
    turn = abs(off[2]) + DETERMINED_SIGMAS * math.sqrt(max(0.0, float(covariance[2, 2])))
    return Undetermined(None, turn, need.heading) if turn > need.heading else None


def room_left(covariance: FloatArray, need: PoseNeed, shift: FloatArray = NO_SHIFT) -> tuple[float, float]:
    """Return the required accuracy of a pose minus 3 sigma of the pose; below 0 the pose is too uncertain.

    Args:
        covariance: (3, 3) covariance of the pose: x and y on the map in [m], heading in [rad].
        need: required accuracy of the pose.
        shift: largest systematic error of the position on the map, in [m], in addition to the covariance;
            (2,) for one error, or (1 + n, 2) with n further, independent errors.

    Returns:
        Margin of the position in its worst direction, in [m], and margin of the heading, in [rad].
    """
    axes, limits = need.axes(covariance)
    if shift.any():
        axes, limits = EVEN_DIRECTIONS, np.full(EVEN_DIRECTIONS.shape[1], limits.min())
    spread = _reach(covariance, axes, shift)
    room = float((limits - spread).min())
    return room, need.heading - DETERMINED_SIGMAS * math.sqrt(max(0.0, float(covariance[2, 2])))


def _reach(covariance: FloatArray, axes: FloatArray, shift: FloatArray) -> FloatArray:
    """Return the limits (k,) of errors along directions that are kept as often as 3 sigma, in [m].

    Matches at one place scatter because walls are at different places in their cells: that part of the
    covariance is in the walls' shifts already.

    Args:
        covariance: (2, 2) or (3, 3) covariance of the pose, of x and y in [m²] first, with that scatter.
        axes: (2, k) unit vectors on the map in columns.
        shift: (2,) or (1 + n, 2) errors of the position on the map, in [m], see `undetermined`.
    """
    sigmas = sigmas_along(covariance, axes)
    alike, *walls = np.abs(np.atleast_2d(shift) @ axes)
    limits = uniform_limits(alike[:, None], sigmas)
    if not walls:
        return limits
    noise = sigmas_along(covariance[:2, :2] - SCAN_REPEATABILITY[:2, :2], axes)
    return np.maximum(limits, uniform_limits(np.transpose(walls), noise))


def sigmas_along(covariance: FloatArray, axes: FloatArray) -> FloatArray:
    """Return the sigmas (k,) of a position along directions, in [m].

    Args:
        covariance: (2, 2) or (3, 3) covariance of the pose on the map, of x and y in [m²] first.
        axes: (2, k) unit vectors on the map in columns.
    """
    variances: FloatArray = np.sum(axes * (covariance[:2, :2] @ axes), axis=0)
    return np.sqrt(np.maximum(variances, 0.0))


def difference(pose: Pose2, goal: Pose2) -> tuple[float, float, float]:
    """Return a pose minus a goal: x and y on the map in [m], and heading in [rad], wrapped to ±pi."""
    return pose.x - goal.x, pose.y - goal.y, wrap(pose.theta - goal.theta)
