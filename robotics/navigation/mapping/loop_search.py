"""Search for loops: which places of a way may be the same, and which closures support each other."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.numerics.arrays import BoolArray, FloatArray, IntArray

from .loop_closure import Loop

VIEW_M = 3.0
"""Largest distance between two keyframes that see the same place."""
MIN_TRAVEL_M = 10.0
"""Length of the shortest loop."""
MAX_SIGMA_M = 5.0
"""Standard deviation of a prediction up to which loops are looked for farther away."""
MAX_CANDIDATES = 3
"""Earlier places tried for one keyframe."""
SUPPORT_KEYFRAMES = 15
"""Keyframes within which another closure has to agree."""
SUPPORT_M, SUPPORT_RAD = 0.3, 0.08
"""Distances within which two closures agree."""


class Candidate(NamedTuple):
    """Two keyframes that may have been recorded at the same place, as a candidate for a loop closure."""

    first: int
    """Number of the earlier keyframe."""
    second: int
    """Number of the later keyframe."""
    distance: float
    """Distance between their estimated positions, in [m]."""


def candidates(
    poses: FloatArray,
    travel: FloatArray,
    second: int,
    sigmas: FloatArray,
    view: float = VIEW_M,
    most: int = MAX_CANDIDATES,
) -> list[Candidate]:
    """Return the earlier keyframes whose place a later keyframe may have come back to, nearest first.

    Of successive keyframes that are all near enough to the later one, only the nearest is returned. At least
    `MIN_TRAVEL_M` of way lie between an earlier keyframe and the later one.

    Args:
        poses: (n, 3) map_T_base of the keyframes: x, y in [m], heading in [rad].
        travel: (n,) length of the way up to each keyframe, in [m].
        second: number of the later keyframe.
        sigmas: (n,) standard deviation of the later keyframe's position relative to each keyframe, in [m].
        view: distance at which two keyframes see the same place, in [m].
        most: maximum number of candidates.
    """
    away = np.hypot(*(poses[:, :2] - poses[second, :2]).T)
    possible = (
        (away < view + 2.0 * np.minimum(sigmas, MAX_SIGMA_M))
        & (travel < travel[second] - MIN_TRAVEL_M)
        & (np.arange(len(poses)) < second)
    )
    found = [
        Candidate(int(run[np.argmin(away[run])]), second, float(away[run].min())) for run in _runs(possible)
    ]
    return sorted(found, key=lambda candidate: candidate.distance)[:most]


def _runs(flags: BoolArray) -> Iterator[IntArray]:
    """Yield the numbers of each unbroken run of True."""
    numbers = np.flatnonzero(flags)
    if len(numbers):
        yield from np.split(numbers, np.flatnonzero(np.diff(numbers) > 1) + 1)


def supported(loops: Sequence[Loop], poses: Sequence[Pose2]) -> list[bool]:
    """Return for each loop closure whether another loop closure, between keyframes nearby, agrees with it.

    The two closures must have different later keyframes. Their earlier keyframes, and their later ones, must
    be at most `SUPPORT_KEYFRAMES` apart. They agree if they mean about the same relative pose.

    Args:
        loops: closures with a match.
        poses: poses of all keyframes in one frame; exact only between neighbouring keyframes.
    """
    return [
        any(_agree(loop, other, poses) for other in loops if other.second != loop.second) for loop in loops
    ]


def _agree(loop: Loop, other: Loop, poses: Sequence[Pose2]) -> bool:
    if (
        abs(loop.first - other.first) > SUPPORT_KEYFRAMES
        or abs(loop.second - other.second) > SUPPORT_KEYFRAMES
    ):
        return False
    assert loop.match is not None and other.match is not None
    to_first = poses[loop.first].relative_to(poses[other.first])
    to_second = poses[other.second].relative_to(poses[loop.second])
    expected = to_first.compose(loop.match.pose).compose(to_second)
    return expected.distance(other.match.pose) < SUPPORT_M and expected.turn(other.match.pose) < SUPPORT_RAD
