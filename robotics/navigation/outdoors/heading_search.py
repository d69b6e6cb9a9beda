"""Which way a base heads whose start heading is unknown: by fixes on the way that it drives."""

from __future__ import annotations

import math
from typing import ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from handcart.robotics.geometry.pose2 import Pose2, wrap
from handcart.robotics.navigation.localization.lost_track import FoundTrack

LONGEST = 600  # fixes that are looked back on
HEADINGS = np.radians(np.arange(720) * 0.5)
KNOWN = math.radians(4.0)  # sigma of a heading that is known
FAR = 3.0  # sigmas beyond which a fix isn't looked at
BAD = 1.6  # times a fix's sigma, by which most of them lie beside the likeliest track
FEWEST = 20  # fixes: a quarter of more of them is forgotten where they don't fit the track
SLIPS = 0.02  # of the way: what odometry itself may be off
LASTS = 4.0  # times the variance, at least, that fixes would have whose errors don't last
ALIKE = 0.98  # correlation of one fix's error with the next one's, at most
BENDS = math.radians(1.0)  # by which the tracks of two biases that are tried differ in the end, at most
MOST = 60  # biases that are tried on either side
UNLIKELY = 1e-9  # share of the likeliest: what is less doesn't count
Array = NDArray[np.float64]


class _Laid(NamedTuple):
    """A track, bent by each bias and turned by each heading, over the fixes."""

    squares: Array
    """(biases, headings) sums of the fixes' squared distances, and of the start's from where it is known."""
    offsets: Array
    """(biases, headings, 2) of the start, in [m]."""


class HeadingSearch:
    """Lays the track that wheels and gyros tell over the fixes, turned by each heading there is.

    A gyro whose bias nobody has seen at rest bends the track: it is bent by each bias that may be, too. The
    heading's likelihood is that of all fixes with the place of the start left open within what is known of
    it; fixes that lie far off the likeliest track don't count. Where most do, odometry was wrong at some
    time: what is oldest is forgotten.
    """

    STATE: ClassVar = {"_track": list[tuple[float, ...]], "_forgotten": bool}
    """Attributes that a checkpoint keeps, with their types."""

    def __init__(self) -> None:
        """No fix yet."""
        self._track: list[tuple[float, ...]] = []
        self._forgotten = False  # whether the track doesn't begin at the start any more

    def take(self, antenna: Array, position: Array, moved: float) -> None:
        """A fix of the antenna's `position` (2,) came where odometry has the `antenna` (2,), both in [m].

        `moved` [s] is how long the base has moved by then: for so long a bias has turned the odometry.
        """
        self._track.append((*antenna.tolist(), *position.tolist(), moved))
        del self._track[:-LONGEST]

    def found(
        self, odometry: Pose2, sigma: float, start_sigma: float, bias_sigma: float = 0.0
    ) -> FoundTrack | None:
        """The pose now, once its heading is known; `odometry` now, at the latest fix.

        Args:
            odometry: where wheels and gyros have the base now; they began at the nominal start.
            sigma: of a fix, an axis, in [m].
            start_sigma: of the start's place, an axis, in [m].
            bias_sigma: of what the vertical gyro reads too much, in [rad/s].
        """
        track = np.array(self._track)
        ways, seen, moved = track[:, :2], track[:, 2:4], track[:, 4]
        reach = float(np.hypot(*(ways - ways[0]).T).max())
        if reach < 3.0 * sigma or reach < 1.0:
            return None
        biases = _biases(bias_sigma, float(moved[-1]))
        bent = np.array([_bent(ways, moved, bias) for bias in biases])
        prior = (sigma / start_sigma) ** 2 if start_sigma > 0.0 else math.inf
        prior = 0.0 if self._forgotten else prior
        unlikely = np.square(biases / bias_sigma)[:, None] if len(biases) > 1 else np.zeros((1, 1))
        counts, scale = np.ones(len(track), dtype=bool), sigma
        for _ in range(3):
            laid = _laid(bent[:, counts], seen[counts], prior)
            price = laid.squares + scale**2 * unlikely
            k, best = np.unravel_index(int(np.argmin(price)), price.shape)
            away = seen - _turned(bent[k], float(HEADINGS[best])) - laid.offsets[k, best]
            left = np.hypot(*away.T)
            scale = max(sigma, float(np.median(left)) / 1.18)
            counts = left <= FAR * scale
        if scale > BAD * sigma and len(track) > FEWEST:
            self._forgotten, self._track = True, self._track[len(track) // 4 :]
            return None
        spread = scale * math.sqrt(_lasting(away[counts]))
        price = laid.squares / spread**2 + unlikely
        likely = np.exp(-0.5 * (price - price.min()))
        place = spread**2 / int(counts.sum()) + 1e-4
        poses = _poses(odometry, ways[-1], float(moved[-1]), biases, bent[:, -1], laid)
        middle = _turned(bent[k], float(HEADINGS[best])).mean(axis=0) + laid.offsets[k, best]
        found = _mixed(poses, likely / likely.sum(), middle, place)
        known = math.sqrt(float(found.covariance[2, 2])) <= KNOWN and counts.mean() >= 0.5
        return found if known else None


def _biases(sigma: float, moved: float) -> Array:
    """(k,) that may be, in [rad/s], by how far they would have turned the track after `moved` [s]."""
    count = min(MOST, int(FAR * sigma * moved / BENDS))
    return FAR * sigma * np.linspace(-1.0, 1.0, 2 * count + 1) if count else np.zeros(1)


def _bent(ways: Array, moved: Array, bias: float) -> Array:
    """The track (n, 2) without what a bias [rad/s] has turned it; `moved` (n,) as in `take`."""
    if bias == 0.0:
        return ways
    turned = -bias * 0.5 * (moved[1:] + moved[:-1])
    cos, sin = np.cos(turned), np.sin(turned)
    x, y = np.diff(ways, axis=0).T
    steps = np.column_stack([cos * x - sin * y, sin * x + cos * y])
    return np.asarray(np.vstack([ways[:1], ways[0] + np.cumsum(steps, axis=0)]))


def _turned(points: Array, angle: float) -> Array:
    """Points (n, 2) turned about the origin."""
    cos, sin = math.cos(angle), math.sin(angle)
    return np.asarray(points @ np.array([[cos, sin], [-sin, cos]]))


def _laid(bent: Array, seen: Array, prior: float) -> _Laid:
    """Tracks (biases, n, 2) over the fixes `seen` (n, 2); the start counts as `prior` of them."""
    cos, sin = np.cos(HEADINGS), np.sin(HEADINGS)
    whole, ways = float((seen**2).sum()), (bent**2).sum(axis=(1, 2))
    along = (bent * seen).sum(axis=(1, 2))
    across = (bent[..., 0] * seen[:, 1] - bent[..., 1] * seen[:, 0]).sum(axis=1)
    (x, y), (seen_x, seen_y) = bent.sum(axis=1).T, seen.sum(axis=0)
    away = np.stack(
        [seen_x - np.outer(x, cos) + np.outer(y, sin), seen_y - np.outer(x, sin) - np.outer(y, cos)], axis=2
    )
    together = whole + ways[:, None] - 2.0 * (np.outer(along, cos) + np.outer(across, sin))
    squares = together - (away**2).sum(axis=2) / (len(seen) + prior)
    return _Laid(squares, away / (len(seen) + prior))


def _lasting(errors: Array) -> float:
    """How many times the variance of fixes (n, 2) counts, by how alike each one's error is to the next one's.

    So many fixes tell as much as one whose error is its own (Bartlett, 1946).
    """
    whole = float((errors**2).sum())
    alike = float((errors[1:] * errors[:-1]).sum()) / whole if whole > 0.0 else 0.0
    alike = min(ALIKE, max(0.0, alike))
    return max(LASTS, (1.0 + alike) / (1.0 - alike))


def _poses(odometry: Pose2, antenna: Array, moved: float, biases: Array, ends: Array, laid: _Laid) -> Array:
    """(biases, headings, 3) of the base now, in [m], [rad].

    `antenna` (2,) is where odometry has it now, `ends` (biases, 2) where it is without each bias.
    """
    lever = antenna - np.array(odometry[:2])
    bases = ends - np.array([_turned(lever[None], -bias * moved)[0] for bias in biases])
    cos, sin = np.cos(HEADINGS), np.sin(HEADINGS)
    x, y = bases.T
    places = np.stack([np.outer(x, cos) - np.outer(y, sin), np.outer(x, sin) + np.outer(y, cos)], axis=2)
    headings = odometry.theta + HEADINGS[None, :] - moved * biases[:, None]
    return np.concatenate([places + laid.offsets, headings[..., None]], axis=2)


def _mixed(poses: Array, likely: Array, middle: Array, place: float) -> FoundTrack:
    """Mean and covariance of poses (biases, headings, 3), by how likely each is (biases, headings).

    Wheels that slip turn the track about its `middle` (2,), which is known to `place` [m²].
    """
    best = poses[np.unravel_index(int(np.argmax(likely)), likely.shape)]
    counts = likely > UNLIKELY
    away, weights = poses[counts] - best, likely[counts] / likely[counts].sum()
    away[:, 2] = (away[:, 2] + math.pi) % (2.0 * math.pi) - math.pi
    mean = weights @ away
    x, y, heading = (best + mean).tolist()
    arm = np.array([x, y]) - middle
    by_turn = np.array([-arm[1], arm[0], 1.0])
    spread = np.einsum("k,ki,kj->ij", weights, away - mean, away - mean)
    slips = (0.5 * SLIPS) ** 2 * np.outer(by_turn, by_turn)
    return FoundTrack(Pose2(x, y, wrap(heading)), spread + slips + np.diag([place, place, 0.0]))
