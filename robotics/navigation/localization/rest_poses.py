"""Comparison of two poses of a base at rest, one of them by a scan."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handcart.robotics.geometry.pose2 import Pose2, wrap
from handcart.robotics.navigation.scans.likelihood_field import LikelihoodField
from handcart.robotics.navigation.scans.scan_matching import ScanMatch
from handcart.robotics.numerics.arrays import FloatArray

MAX_REST_SPREAD = (
    0.010,
    0.010,
)  # [m], [rad] by which scans of one place never differ: eight times their spread
# squared difference of two poses at rest, by its covariance, above which the base was moved: by chance it is
# exceeded in one of a million looks (three degrees of freedom), and a run has thousands
MIN_DISPLACED_SQUARE = 30.7
SHARE_OF_CELL = 0.2  # by which they never differ on large cells, where several places fit alike


class RestPose(NamedTuple):
    """Pose of a base at rest with which a later scan is compared."""

    pose: Pose2
    """map_T_base."""
    covariance: FloatArray
    """(3, 3) of x, y on the map in [m] and heading in [rad], without the map's error."""


def is_apart(
    before: Pose2, after: ScanMatch, covariance: FloatArray, field: LikelihoodField, surface_error: float
) -> bool:
    """Return whether two poses measured by scans differ by more than their errors: the base was moved.

    Args:
        before: map_T_base of the first pose.
        after: match that gives the second pose.
        covariance: (3, 3) of their difference on the map if the base has not moved, in [m, m, rad].
        field: likelihood field of the map.
        surface_error: error of the map's surfaces, in [m].
    """
    most = max(MAX_REST_SPREAD[0], SHARE_OF_CELL * field.map.resolution, surface_error)
    if before.distance(after.pose) <= most and before.turn(after.pose) <= MAX_REST_SPREAD[1]:
        return False
    off = pose_difference(before, after.pose)
    return float(off @ np.linalg.solve(covariance, off)) > MIN_DISPLACED_SQUARE


def pose_difference(before: Pose2, after: Pose2) -> FloatArray:
    """Return the difference (3,) `after` minus `before`: x, y along the map's axes in [m] and turn in [rad].

    Args:
        before: map_T_base of the first pose.
        after: map_T_base of the second pose.
    """
    x, y, turn = np.subtract(after, before).tolist()
    return np.array([x, y, wrap(turn)])
