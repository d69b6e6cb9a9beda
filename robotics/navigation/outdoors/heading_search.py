"""Which way a base heads that nobody has told: by fixes on the way that it drives."""

from __future__ import annotations

import math
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from handcart.robotics.geometry.pose2 import Pose2, wrap
from handcart.robotics.navigation.localization.lost_track import FoundTrack

LONGEST = 600  # fixes that are looked back on
HEADINGS = np.radians(np.arange(720) * 0.5)
KNOWN = math.radians(4.0)  # sigma of a heading that is known
FAR = 3.0  # sigmas beyond which a fix isn't looked at
SLIPS = 0.02  # of the way: what odometry itself may be off
LASTS = 4.0  # times the variance, at least, that fixes would have whose errors don't last
ALIKE = 0.98  # correlation of one fix's error with the next one's, at most
Array = NDArray[np.float64]


class HeadingSearch:
    """Lays the track that wheels and gyros tell over the fixes, turned by each heading there is.

    The heading's likelihood is that of all fixes with the place of the start left open within what is known
    of it; fixes that lie far off the likeliest track don't count.
    """

    STATE: ClassVar = {"_track": list[tuple[float, ...]]}
    """Attributes that a checkpoint keeps, with their types."""

    def __init__(self) -> None:
        """No fix yet."""
        self._track: list[tuple[float, ...]] = []

    def take(self, antenna: Array, position: Array) -> None:
        """A fix of the antenna's `position` (2,) came where odometry has the `antenna` (2,), both in [m]."""
        self._track.append((*antenna.tolist(), *position.tolist()))
        del self._track[:-LONGEST]

    def found(self, odometry: Pose2, sigma: float, start_sigma: float) -> FoundTrack | None:
        """The pose now, once its heading is known; `odometry` now.

        Args:
            odometry: where wheels and gyros have the base now; they began at the start that was told.
            sigma: of a fix, an axis, in [m].
            start_sigma: of the start's place, an axis, in [m].
        """
        track = np.array(self._track)
        ways, seen = track[:, :2], track[:, 2:]
        reach = float(np.hypot(*(ways - ways[0]).T).max())
        if reach < 3.0 * sigma or reach < 1.0:
            return None
        cos, sin = np.cos(HEADINGS)[:, None], np.sin(HEADINGS)[:, None]
        turned = np.stack([cos * ways[:, 0] - sin * ways[:, 1], sin * ways[:, 0] + cos * ways[:, 1]], axis=2)
        away = seen - turned  # (headings, fixes, 2)
        counts = np.ones(len(track), dtype=bool)
        prior = (sigma / start_sigma) ** 2 if start_sigma > 0.0 else math.inf
        for _ in range(3):
            near = away[:, counts]
            offset = near.sum(axis=1) / (near.shape[1] + prior)
            squares = (near**2).sum(axis=(1, 2)) - (offset**2).sum(axis=1) * (near.shape[1] + prior)
            best = int(np.argmin(squares))
            left = np.hypot(*(away[best] - offset[best]).T)
            scale = max(sigma, float(np.median(left)) / 1.18)
            counts = left <= FAR * scale
        spread = scale * math.sqrt(_lasting((away[best] - offset[best])[counts]))
        likely = np.exp(-0.5 * (squares - squares.min()) / spread**2)
        likely /= likely.sum()
        apart = np.array([wrap(float(heading - HEADINGS[best])) for heading in HEADINGS])
        mean = float(likely @ apart)
        about = math.sqrt(float(likely @ (apart - mean) ** 2) + (0.5 * SLIPS) ** 2)
        if about > KNOWN or counts.mean() < 0.5:
            return None
        turn = wrap(float(HEADINGS[best]) + mean)
        place = spread**2 / int(counts.sum()) + 1e-4
        return _pose(odometry, turn, offset[best], about, ways.mean(axis=0), place)


def _lasting(errors: Array) -> float:
    """How many times the variance of fixes (n, 2) counts, by how alike each one's error is to the next one's.

    So many fixes tell as much as one whose error is its own (Bartlett, 1946).
    """
    whole = float((errors**2).sum())
    alike = float((errors[1:] * errors[:-1]).sum()) / whole if whole > 0.0 else 0.0
    alike = min(ALIKE, max(0.0, alike))
    return max(LASTS, (1.0 + alike) / (1.0 - alike))


def _pose(
    odometry: Pose2, turn: float, offset: Array, about: float, middle: Array, place: float
) -> FoundTrack:
    """Of a track turned about the origin, its middle known to `place` [m²], its heading to `about` [rad]."""
    turned = Pose2(0.0, 0.0, turn)
    x, y = turned.apply(np.array([odometry[:2]])).reshape(2) + offset
    arm = turned.apply(np.array([odometry[:2]]) - middle).reshape(2)
    by_turn = np.array([-arm[1], arm[0], 1.0])
    covariance = about**2 * np.outer(by_turn, by_turn) + np.diag([place, place, 0.0])
    return FoundTrack(Pose2(float(x), float(y), wrap(odometry.theta + turn)), covariance)
