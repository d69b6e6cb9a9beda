"""Detection that refused fixes are right and the filter is wrong."""

from __future__ import annotations

import math
from typing import ClassVar, NamedTuple

import numpy as np

from handcart.robotics.geometry.pose2 import Pose2, wrap
from handcart.robotics.numerics.arrays import FloatArray

MAX_REVIEWED_FIXES = 300  # fixes that are looked back on
MIN_REVIEWED_FIXES = 10  # fixes to judge by
TURNED_SIGMAS = 6.0  # sigmas of a turn that can't be chance
LEAST_TURN = math.radians(5.0)
# root mean square of the fixes around the odometry's track, in sigmas: above it they do not agree
MAX_AGREEING_RMS_SIGMAS = 1.4
ODOMETRY_ERROR_RATIO = 0.02  # of the way: error of the odometry itself


class FoundTrack(NamedTuple):
    """Pose of the robot computed from GNSS fixes that the filter has rejected, with its covariance."""

    pose: Pose2
    covariance: FloatArray
    """(3, 3) of x, y and heading in the field's frame, in [m, m, rad]."""


class LostTrack:
    """Detector of a lost filter, which compares the track of rejected fixes with the track of the odometry.

    If the filter's heading is wrong, the fixes have the shape of the odometry's track, but are turned, which
    is noticed as soon as the robot moves. A track that is only shifted may also come from a reflection of
    signals, and is used only after `patience` fixes.
    """

    STATE: ClassVar = {"_patience": int, "_tracks": list[tuple[float, ...]]}
    """Attributes that a checkpoint keeps, with their types."""

    def __init__(self, patience: int = 200) -> None:
        """Start without a fix; `patience` is a number of fixes, more than a reflection lasts."""
        self._patience = patience
        self._tracks: list[tuple[float, ...]] = []

    def take(self, reckoned: Pose2, position: FloatArray, believed: bool) -> None:
        """Record a fix together with the pose by odometry.

        Args:
            reckoned: pose by odometry alone when the fix was received, in the field's frame.
            position: (2,) position of the base by the fix, in the field's frame, in [m].
            believed: True if the filter used the fix.
        """
        self._tracks.append((*reckoned, float(position[0]), float(position[1]), float(believed)))
        del self._tracks[:-MAX_REVIEWED_FIXES]

    def doubt(self, count: int) -> None:
        """Mark as rejected the last `count` fixes that the filter used."""
        for k in range(len(self._tracks) - 1, -1, -1):
            if count > 0 and self._tracks[k][5]:
                self._tracks[k] = (*self._tracks[k][:5], 0.0)
                count -= 1

    def found(self, sigma: float, estimate: Pose2, heading_sigma: float) -> FoundTrack | None:
        """Return a pose that fits the rejected fixes better than the filter's estimate; None if there is
        none.

        At least `MIN_REVIEWED_FIXES` fixes in a row have to be rejected before. If a pose is returned, all
        recorded fixes are discarded.

        Args:
            sigma: standard deviation of a fix along each axis, in [m].
            estimate: present pose by the filter, in the field's frame.
            heading_sigma: standard deviation of the estimate's heading, in [rad].
        """
        tracks = np.array(self._tracks)
        believed = np.flatnonzero(tracks[:, 5])
        refused = tracks[believed[-1] + 1 :] if len(believed) else tracks
        if len(refused) < MIN_REVIEWED_FIXES:
            return None
        found = _turned(refused, sigma, estimate)
        if found is None and len(refused) >= self._patience:
            found = _shifted(refused, sigma, estimate, heading_sigma)
        if found is not None:
            self._tracks.clear()
        return found


def _turned(refused: FloatArray, sigma: float, estimate: Pose2) -> FoundTrack | None:
    """Return the pose if the fixes lie on a turned track."""
    found = _fit(refused, sigma)
    if found is None:
        return None
    away = abs(wrap(found.pose.theta - estimate.theta))
    sure = away > max(LEAST_TURN, TURNED_SIGMAS * math.sqrt(float(found.covariance[2, 2])))
    return found if sure else None


def _shifted(refused: FloatArray, sigma: float, estimate: Pose2, heading_sigma: float) -> FoundTrack | None:
    """Return the pose if the fixes lie on a parallel track; the heading is that of the estimate."""
    last = Pose2(*refused[-1, :3].tolist())
    moved = [estimate.compose(Pose2(*row[:3].tolist()).relative_to(last)) for row in refused]
    away = refused[:, 3:5] - np.array(moved)[:, :2]
    shift = np.median(away, axis=0)
    spread = float(np.sqrt(np.mean((away - shift) ** 2)))
    if spread > MAX_AGREEING_RMS_SIGMAS * sigma + ODOMETRY_ERROR_RATIO * _length(refused):
        return None
    variance = sigma**2 + spread**2
    pose = Pose2(estimate.x + float(shift[0]), estimate.y + float(shift[1]), estimate.theta)
    return FoundTrack(pose, np.diag([variance, variance, max(heading_sigma, math.radians(3.0)) ** 2]))


def _length(tracks: FloatArray) -> float:
    """Return the length of the odometry's track, in [m]."""
    return float(np.hypot(*np.diff(tracks[:, :2], axis=0).T).sum())


def _fit(tracks: FloatArray, sigma: float) -> FoundTrack | None:
    """Return the present pose by laying the odometry's track over the fixes (Umeyama, 1991), if they
    agree.
    """
    reckoned, seen = tracks[:, :2], tracks[:, 3:5]
    reckoned_middle, seen_middle = reckoned.mean(axis=0), seen.mean(axis=0)
    a, b = reckoned - reckoned_middle, seen - seen_middle
    reach = float((a**2).sum())
    if reach < (5.0 * sigma) ** 2:
        return None
    turn = math.atan2(float((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum()), float((a * b).sum()))
    cos, sin = math.cos(turn), math.sin(turn)
    rotation = np.array([[cos, -sin], [sin, cos]])
    residual = float(np.sqrt(np.mean((b - a @ rotation.T) ** 2)))
    if residual > MAX_AGREEING_RMS_SIGMAS * sigma + ODOMETRY_ERROR_RATIO * _length(tracks):
        return None
    noise = max(sigma, residual)
    last = rotation @ (reckoned[-1] - reckoned_middle)
    x, y = (seen_middle + last).tolist()
    pose = Pose2(x, y, wrap(float(tracks[-1, 2]) + turn))
    by_turn = np.array([-last[1], last[0], 1.0])
    heading = 4.0 * noise**2 / reach + ODOMETRY_ERROR_RATIO**2
    place = 4.0 * noise**2 / len(tracks) + 1e-4
    return FoundTrack(pose, heading * np.outer(by_turn, by_turn) + np.diag([place, place, 0.0]))
