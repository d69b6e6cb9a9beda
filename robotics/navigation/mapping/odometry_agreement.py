"""Comparison of the motions that scans show with those of the odometry.

The scans of a lidar whose beams are mirrored, or whose heading on the base is wrong, fit each other as well
as correct ones: only the odometry contradicts them.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from handcart.robotics.numerics.arrays import FloatArray

MIN_TURN_RAD, MIN_TRAVEL_M = 2.0, 2.0
"""Turn and travel of the odometry below which nothing is compared."""
RATIO_LIMITS = (0.7, 1.4)
"""Turn or travel of the scans, as multiples of the odometry's, between which the two agree."""
MAX_OFF_RAD = math.radians(15.0)
"""Angle between the directions of travel up to which they agree; wheels that slip sideways need some."""


class OdometryAgreement(NamedTuple):
    """Motions between keyframes by scans, compared with those by odometry; None if there are too few."""

    turn_ratio: float | None
    """Turn of the scans, as a multiple of the odometry's; negative in the opposite direction."""
    travel_ratio: float | None
    """Travel of the scans, as a multiple of the odometry's."""
    off_rad: float | None
    """Angle from the odometry's direction of travel to that of the scans, counter-clockwise."""


def odometry_agreement(odometry: FloatArray, poses: FloatArray) -> OdometryAgreement:
    """Return how well the motions between keyframes agree.

    Args:
        odometry: (n, 3) odom_T_base of each keyframe: x, y in [m], heading in [rad].
        poses: (n, 3) map_T_base of each keyframe, as its scan was matched.
    """
    (stated, stated_turns), (found, found_turns) = _motions(odometry), _motions(poses)
    turn = travel = off = None
    if np.abs(stated_turns).sum() >= MIN_TURN_RAD:
        turn = float((stated_turns * found_turns).sum() / (stated_turns**2).sum())
    if np.abs(stated).sum() >= MIN_TRAVEL_M:
        mean = complex((stated.conj() * found).sum() / (np.abs(stated) ** 2).sum())
        travel, off = abs(mean), math.atan2(mean.imag, mean.real)
    return OdometryAgreement(turn, travel, off)


def disagreement_in_words(agreement: OdometryAgreement) -> Iterator[str]:
    """Yield a message for each way in which scans and odometry contradict each other."""
    turn, travel, off = agreement
    low, high = RATIO_LIMITS
    if turn is not None and turn < 0.0:
        yield (
            f"the scans turn in the opposite direction of the odometry ({turn:.2f} times as far): the beams "
            "run the other way round than the log says and the map is mirrored, or the odometry turns wrongly"
        )
    elif turn is not None and not low <= turn <= high:
        yield f"the scans turn {turn:.2f} times as far as the odometry: check angles and odometry"
    if travel is not None and not low <= travel <= high:
        yield f"the scans move {travel:.3g} times as far as the odometry: check the units of both"
    elif off is not None and abs(off) > MAX_OFF_RAD:
        side = "left" if off > 0.0 else "right"
        yield (
            f"the scans move {abs(math.degrees(off)):.0f} deg to the {side} of the odometry's direction: the "
            "heading of the lidar on the base is wrong by as much, or that of the odometry"
        )


def _motions(poses: FloatArray) -> tuple[np.ndarray, FloatArray]:
    """Return the motions between successive poses: (n-1,) complex, x + iy in the frame of the first of two in
    [m], and (n-1,) turns in [rad].
    """
    places = poses[:, 0] + 1j * poses[:, 1]
    turns = np.angle(np.exp(1j * np.diff(poses[:, 2])))
    return np.diff(places) * np.exp(-1j * poses[:-1, 2]), turns
