"""Comparison of a base's motion by its wheels with that by its scans, without any map.

A base that something holds (the edge of a table, a low bar, a foot) turns its wheels and stays. Its scans
stay the same, too: they show how far it moved.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.mapping.line_matching import match_surfaces
from handcart.robotics.navigation.mapping.scan_surface import Surface, fit_surface
from handcart.robotics.navigation.odometry.odometry import OdometryErrors
from handcart.robotics.navigation.scans.start_search import ScanBeams
from handcart.robotics.numerics.arrays import FloatArray
from handcart.robotics.numerics.compiled import compiled

from .moved_scan import beam_step, moved_echoes, rolled_motion, same_ranges

MIN_MOTION_M, MIN_MOTION_RAD = 0.03, 0.03
"""Motion by the wheels, less of which is not compared with scans."""
SHORT_BASELINE, LONG_BASELINE = (0.03, 0.03), (0.2, 0.25)
"""Motion by the wheels in [m] and in [rad], after which a scan is replaced by a later one."""
MAX_REFERENCE_M, MAX_REFERENCE_RAD = 0.5, 1.0
"""Motion by the wheels, after which the reference is too old."""
CLEAR_DIFFERENCE = 0.06
"""Difference of the disagreements of two motions with the scans, from which scans contradict the wheels."""
MAX_LAG_S = 0.15
"""Time by which scans may be older than the wheels' readings."""
MIN_SHARE_OFF = 0.3
"""Minimum share of the wheels' motion by which scans must differ; wheels that roll freely slip by less."""
WRONG_SIGMAS = 4.0
MIN_INLIERS = 0.6
"""Share of the earlier scan that the later one must show again."""
MIN_INFORMATION_SHARE = 0.05
"""Share of the information along the best direction, below which the other direction is undetermined."""
SMALL_GATES_M = (0.2, 0.1)
AGREEMENT_SCALE_M = 0.05
"""Difference of ranges at which a beam's disagreement is one half."""
FASTEST_KEPT = 0.8
"""Share of the greatest speed that is kept from one reference to the next: scans lag behind a stop."""
AGREEING_SCANS = 6
"""Number of scans in a row that must agree with the wheels again before the wheels are believed."""
MIN_BEAMS = 20
MAX_SLIDE_M, MAX_SLIDE_RAD = 0.15, 0.3
"""Motion beyond that of the wheels from one scan to the next: more, and the base was lifted, not held."""


class Contradiction(NamedTuple):
    """Pose of a base by its scans, which contradict the travel of its wheels."""

    pose: Pose2
    """map_T_base by the pose at the earlier scan, and the motion that the scans show."""
    covariance: FloatArray
    """(3, 3) of the motion by the scans, on the map: x, y in [m] and heading in [rad]."""


class WheelCheck:
    """Detector of wheels that do not move the base as measured, which compares each scan with two earlier
    ones.

    Before the comparison, each earlier scan is moved by the motion that the wheels have measured since then.
    The comparison with the later of the two scans shows quickly that the base is held; the comparison with
    the other one shows wheels that slip partly.

    Attributes:
        is_doubtful: True if the last scan fits better where the base moved less than its wheels did.
        is_contradicted: True from the first contradiction until scans and wheels agree again.
    """

    def __init__(self, tread: float, errors: OdometryErrors, period: float) -> None:
        """Begin without scans.

        Args:
            tread: distance of the wheels, in [m].
            errors: of the wheels.
            period: control period, in [s].
        """
        self._lag_periods = MAX_LAG_S / period
        self._baselines = tuple(Baseline(tread, errors, *least) for least in (SHORT_BASELINE, LONG_BASELINE))
        self._last = np.empty(0)
        self._agreeing = 0
        self.is_doubtful = self.is_contradicted = False

    def roll(self, left: float, right: float, sideways: float) -> None:
        """Move the earlier scans, with which the next scan will be compared, by the wheels' travel in a
        period.

        Args:
            left: travel of the left wheels, in [m].
            right: travel of the right wheels, in [m].
            sideways: travel to the left, in [m].
        """
        for baseline in self._baselines:
            baseline.roll(left, right, sideways)

    def note_pose(self, pose: Pose2) -> None:
        """Set the estimate of map_T_base after this period's scan was taken into account; called after
        `take`.
        """
        for baseline in self._baselines:
            baseline.note_pose(pose)

    def take(self, beams: ScanBeams) -> Contradiction | None:
        """Compare a scan with the earlier ones; return the base's pose if the scans contradict the wheels.

        The result is None if scans and wheels agree. After a contradiction, later scans are compared with
        this scan.
        """
        if same_ranges(self._last, beams.ranges):
            return None  # an old scan given again
        self._last = beams.ranges
        compared = [baseline for baseline in self._baselines if baseline.compares(beams)]
        if not compared:
            return None
        doubted = [item for item in compared if item.fits_elsewhere(beams)]
        self.is_doubtful = bool(doubted)
        self._agreeing = 0 if doubted else self._agreeing + 1
        self.is_contradicted = self.is_contradicted and self._agreeing < AGREEING_SCANS
        for item in compared:
            if not doubted and item.is_complete:
                item.begin(beams)
        lag = 0.0 if self.is_contradicted else self._lag_periods
        found = next((fit for item in doubted if (fit := item.contradiction(beams, lag))), None)
        if found is not None:
            self.is_contradicted = True
            for baseline in self._baselines:
                baseline.begin(beams)
        return found

    def reset(self) -> None:
        """Discard all scans so far, because the base was not moved by its wheels alone."""
        for baseline in self._baselines:
            baseline.reset()
        self._agreeing = 0
        self.is_doubtful = self.is_contradicted = False


class Baseline:
    """Earlier scan with which later scans are compared, and the travel of the wheels since then."""

    def __init__(self, tread: float, errors: OdometryErrors, way: float, turn: float) -> None:
        """Begin without a scan.

        Args:
            tread: distance of the wheels, in [m].
            errors: of the wheels.
            way: travel of a wheel after which the scan is replaced, in [m].
            turn: turn after which the scan is replaced, in [rad].
        """
        self._tread, self._errors, self._complete = tread, errors, (way, turn)
        self._before: ScanBeams | None = None
        self._surface: Surface | None = None
        self._then = Pose2(0.0, 0.0, 0.0)  # map_T_base at that scan
        self._left, self._right, self._sideways, self._way = 0.0, 0.0, 0.0, 0.0
        self._fastest = np.zeros(2)  # distance in [m] and turn in [rad] by the wheels in a period
        self._moved = Pose2(0.0, 0.0, 0.0)

    def roll(self, left: float, right: float, sideways: float) -> None:
        """Add a period's travel, in [m]: of the left wheels, of the right wheels, and sideways (left)."""
        step = rolled_motion(left, right, sideways, self._tread)
        self._moved = self._moved.compose(step)
        self._left, self._right = self._left + left, self._right + right
        self._sideways, self._way = self._sideways + sideways, self._way + abs(left) + abs(right)
        self._fastest = np.maximum(self._fastest, _size(step))

    def note_pose(self, pose: Pose2) -> None:
        """Set the pose of the earlier scan to an estimated map_T_base.

        Nothing changes if the wheels have moved since that scan.
        """
        if self._way == 0.0 and self._sideways == 0.0:
            self._then = pose

    def begin(self, beams: ScanBeams) -> None:
        """Replace the earlier scan, with which later scans are compared, and measure the wheels' travel since
        the new one.

        Args:
            beams: scan that takes its place.
        """
        self._before, self._surface = beams, None
        self._left = self._right = self._sideways = self._way = 0.0
        self._moved, self._fastest = Pose2(0.0, 0.0, 0.0), FASTEST_KEPT * self._fastest

    def reset(self) -> None:
        """Discard the kept reference scan, so that the next scan is not compared but becomes the new
        reference.
        """
        self._before, self._surface = None, None

    def compares(self, beams: ScanBeams) -> bool:
        """Return whether the wheels have moved by `MIN_MOTION_M` or `MIN_MOTION_RAD` since the kept scan, so
        that a new scan can be compared with it.

        If there is no kept scan, if the wheels have moved more than `MAX_REFERENCE_M` or `MAX_REFERENCE_RAD`
        since, or if it has other beams, the new scan replaces it, and the result is False.
        """
        before = self._before
        old = self._has_moved(MAX_REFERENCE_M, MAX_REFERENCE_RAD)
        if before is None or old or len(before.angles) != len(beams.angles):
            self.begin(beams)
            return False
        return self._has_moved(MIN_MOTION_M, MIN_MOTION_RAD)

    @property
    def is_complete(self) -> bool:
        """True if the wheels have moved so far since the reference scan that the next scan may replace it."""
        return self._has_moved(*self._complete)

    def _has_moved(self, way: float, turn: float) -> bool:
        rolled = max(abs(self._left), abs(self._right), abs(self._sideways))
        return rolled > way or abs(self._right - self._left) > turn * self._tread

    def fits_elsewhere(self, beams: ScanBeams) -> bool:
        """Return whether a scan shows that the base, or one of its wheels, was probably held.

        That is so if the scan fits the reference scan better, by more than `CLEAR_DIFFERENCE`, at the pose of
        a held base than at the pose that the wheels have measured.
        """
        own = self._disagreement(beams, self._moved)
        if own <= CLEAR_DIFFERENCE:
            return False
        return any(self._disagreement(beams, item) < own - CLEAR_DIFFERENCE for item in self._held())

    def _held(self) -> list[Pose2]:
        """Return the motions of a base that is held, or held at one wheel."""
        shares = ((0.0, 0.0, 0.0), (0.5, 0.5, 0.5), (0.0, 1.0, 1.0), (1.0, 0.0, 1.0))
        return [
            rolled_motion(one * self._left, two * self._right, three * self._sideways, self._tread)
            for one, two, three in shares
        ]

    def _disagreement(self, beams: ScanBeams, moved: Pose2) -> float:
        back, before = moved.inverse(), self._before
        assert before is not None
        then = before.origin, before.angles, before.ranges
        pose = (back.x, back.y, back.theta)
        return float(disagreement_of_ranges(then, pose, beams.origin, beams.angles, beams.ranges))

    def contradiction(self, beams: ScanBeams, lag: float) -> Contradiction | None:
        """Return the base's pose by a scan if it contradicts the motion measured by the wheels, otherwise
        None.

        Args:
            beams: beams of the scan.
            lag: number of periods by which scans may be older than the wheels' readings.
        """
        starts = sorted(self._held(), key=lambda item: self._disagreement(beams, item))
        if self._surface is None:
            assert self._before is not None
            self._surface = fit_surface(self._before.points, self._before.origin)
        now = fit_surface(beams.points, beams.origin)
        way, turn = (_size(self._moved) + np.array([MIN_MOTION_M, MIN_MOTION_RAD])).tolist()
        prior = np.diag([way**-2, way**-2, turn**-2])
        match = match_surfaces(self._surface, now, starts[0], prior, SMALL_GATES_M)
        noise = np.asarray(np.linalg.inv(_determined(match.information, prior)), dtype=np.float64)
        if match.inliers < MIN_INLIERS or not self._is_beyond(match.pose, noise, lag):
            return None
        if (_size(match.pose) - _size(self._moved) > np.array([MAX_SLIDE_M, MAX_SLIDE_RAD])).any():
            return None
        pose = self._then.compose(match.pose)
        cos, sin = math.cos(self._then.theta), math.sin(self._then.theta)
        rotation = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
        return Contradiction(pose, rotation @ noise @ rotation.T)

    def _is_beyond(self, moved: Pose2, noise: FloatArray, lag: float) -> bool:
        """Return whether a motion is not that of the wheels, whatever their errors and the lag of scans."""
        errors, (way, turn) = self._errors, _size(self._moved)
        slip = errors.slip**2 * errors.slip_length * self._way
        by_turn = (slip + 2.0 * (errors.radius * way) ** 2) / self._tread**2 + (errors.tread * turn) ** 2
        claimed = np.array([0.25 * slip + (errors.radius * way) ** 2, by_turn])
        sigmas = np.sqrt(claimed + np.array([max(noise[0, 0], noise[1, 1]), noise[2, 2]]))
        least = np.maximum(WRONG_SIGMAS * sigmas, MIN_SHARE_OFF * np.array([way, turn]))
        off = _size(moved.relative_to(self._moved))
        return bool((off > np.maximum(least, lag * self._fastest)).any())


def _determined(information: FloatArray, prior: FloatArray) -> FloatArray:
    """Return the information (3, 3) of a match without that about a direction which it hardly determines.

    Along a corridor such information comes from the normals' errors; there only the `prior` (3, 3) is left.
    """
    values, directions = np.linalg.eigh((information - prior)[:2, :2])
    if values[0] > MIN_INFORMATION_SHARE * values[1]:
        return information
    along = np.array([*directions[:, 0], 0.0])
    rest = np.eye(3) - np.outer(along, along)
    return np.asarray(rest @ (information - prior) @ rest + prior)


def _size(motion: Pose2) -> FloatArray:
    """Return the distance in [m] and the turn in [rad] of a motion (2,), without signs."""
    return np.array([math.hypot(motion.x, motion.y), abs(motion.theta)])


@compiled
def disagreement_of_ranges(
    before: tuple[FloatArray, FloatArray, FloatArray],
    moved: tuple[float, float, float],
    sensor: FloatArray,
    angles: FloatArray,
    ranges: FloatArray,
) -> float:
    """Return how much two scans of the same surroundings differ, from 0 to 1; 0 if too few beams can be
    compared.

    It is the mean of a robust function of the ranges' differences.

    Args:
        before: origin (2,) in [m], angles (m,) in [rad] and ranges (m,) in [m] of the earlier scan, in the
            base frame at the time of that scan.
        moved: pose of the base at the earlier scan, in the present base frame: x, y in [m], heading in [rad].
        sensor: (2,) origin of the beams in the present base frame, in [m].
        angles: (n,) angles of the present scan's beams in the present base frame, ascending in even steps, in
            [rad].
        ranges: (n,) ranges of the present scan, in [m].
    """
    count, step = len(angles), beam_step(angles)
    if step <= 0.0:
        return 0.0
    total, compared = 0.0, 0
    ends = np.empty((count, 2))
    for i in range(count):
        angle = angles[0] + i * step
        ends[i, 0], ends[i, 1] = ranges[i] * math.cos(angle), ranges[i] * math.sin(angle)
    for x, y in moved_echoes(before, moved, sensor):
        if math.isnan(x):
            continue
        away = math.sqrt(x * x + y * y)
        at = ((math.atan2(y, x) - angles[0]) % (2.0 * math.pi)) / step
        low = int(at)
        if low + 1 >= count or not (math.isfinite(ranges[low]) and math.isfinite(ranges[low + 1])):
            continue
        begin_x, begin_y = ends[low, 0], ends[low, 1]
        line_x, line_y = ends[low + 1, 0] - begin_x, ends[low + 1, 1] - begin_y
        length = math.sqrt(line_x * line_x + line_y * line_y) + 1e-9
        beside = abs((x - begin_x) * line_y - (y - begin_y) * line_x) / length
        off = min(beside, abs(away - ranges[low]), abs(away - ranges[low + 1]))
        compared += 1
        total += off * off / (off * off + AGREEMENT_SCALE_M**2)
    return total / compared if compared >= MIN_BEAMS else 0.0
