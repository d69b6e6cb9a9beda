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
LASTS = 2.0  # times as unsure as if errors of fixes didn't last from one to the next
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
        likely = np.exp(-0.5 * (squares - squares.min()) / (LASTS * scale) ** 2)
        likely /= likely.sum()
        apart = np.array([wrap(float(heading - HEADINGS[best])) for heading in HEADINGS])
        mean = float(likely @ apart)
        spread = math.sqrt(float(likely @ (apart - mean) ** 2) + (0.5 * SLIPS) ** 2)
        if spread > KNOWN or counts.mean() < 0.5:
            return None
        turn = wrap(float(HEADINGS[best]) + mean)
        return self._pose(odometry, turn, offset[best], spread, ways.mean(axis=0), scale, int(counts.sum()))

    def _pose(
        self,
        odometry: Pose2,
        turn: float,
        offset: Array,
        spread: float,
        middle: Array,
        scale: float,
        count: int,
    ) -> FoundTrack:
        """Of a track turned about the origin; what is least sure about the place is far from its middle."""
        x, y = Pose2(0.0, 0.0, turn).apply(np.array([odometry[:2]])).reshape(2) + offset
        arm = Pose2(0.0, 0.0, turn).apply(np.array([odometry[:2]]) - middle).reshape(2)
        by_turn = np.array([-arm[1], arm[0], 1.0])
        place = (LASTS * scale) ** 2 / count + 1e-4
        covariance = spread**2 * np.outer(by_turn, by_turn) + np.diag([place, place, 0.0])
        return FoundTrack(Pose2(float(x), float(y), wrap(odometry.theta + turn)), covariance)
