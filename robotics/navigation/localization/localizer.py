"""Interface of localizers, and odometry corrected by scans."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from typing import Any, ClassVar

import numpy as np
from typing_extensions import override

from handcart.robotics.geometry.pose2 import Pose2, wrap
from handcart.robotics.navigation.localization.rest_poses import RestPose, is_apart, pose_difference
from handcart.robotics.navigation.localization.unmapped_surroundings import UnmappedSurroundings
from handcart.robotics.navigation.odometry.holonomic_odometry import odometry_of
from handcart.robotics.navigation.odometry.odometry import Odometry, OdometryErrors
from handcart.robotics.navigation.odometry.slip_monitor import RolledWay, SlipMonitor, turn_variance
from handcart.robotics.navigation.odometry.way_monitor import WayMonitor
from handcart.robotics.navigation.scans.scan_matching import (
    CELL_SIGMA,
    FEWEST_POINTS,
    LikelihoodField,
    ScanMatch,
    match_scan,
)
from handcart.robotics.navigation.scans.start_search import ScanBeams, StartFit, check_start
from handcart.robotics.numerics.arrays import FloatArray
from handcart.robotics.numerics.covariances import remove_part

LEAST_INLIERS = 0.4  # share of a scan's points that the map must explain for a match to be believed
SEARCH_COVARIANCE = np.diag([0.3, 0.3, 0.17]) ** 2  # [m², rad²] of a pose that is looked for
# [m², rad²] of an unnoticed push of a base at rest
NUDGE_COVARIANCE = np.diag([0.0125, 0.0125, 0.005]) ** 2
SCANS_TELL = 0.3  # share of the heading's error that a scan leaves, at most, to be held against the wheels
# share of the points explained so far; fewer, and the pose is looked for farther away
MIN_SHARE_KEPT_AT_REST = 0.9
MAX_SIDEWAYS_RATIO = 0.2  # of the way ahead; more of it, and the length of the way ahead is not compared


class Localizer(ABC):
    """Base class of estimators of map_T_base from the travel of the wheels and from lidar scans."""

    STATE: ClassVar[Mapping[str, Any]] = {}
    """Attributes that change, besides the odometry's, with their types."""
    CORRECTS_BY_SCANS: ClassVar[bool] = True
    """False if `correct` ignores scans, so that none need be taken."""

    def __init__(
        self,
        start: Pose2,
        tread: float,
        errors: OdometryErrors = OdometryErrors(),
        covariance: FloatArray | None = None,
    ) -> None:
        """Start at map_T_base, certain or with a covariance (3, 3); `tread` of the wheels in [m]."""
        self._odometry = odometry_of(start, tread, errors, covariance)
        self.surface_error = 0.0
        """Error in [m] of surfaces on the map, beyond that of its cells."""

    @property
    def odometry(self) -> Odometry:
        """Pose with covariance that is moved by the wheels' travel and corrected by other measurements."""
        return self._odometry

    @property
    def looks(self) -> bool:
        """True if the localizer compares lidar scans with a map or with earlier scans."""
        return True

    @property
    def pose(self) -> Pose2:
        """Estimated pose of the base on the map (map_T_base)."""
        return self._odometry.pose

    @property
    def covariance(self) -> FloatArray:
        """Covariance (3, 3) of the pose's x, y in [m] and heading in [rad], in the map frame."""
        return self._odometry.covariance

    def predict(self, left: float, right: float, sideways: float = 0.0) -> None:
        """Move the pose by the wheels' travel since the last call, in [m]; `sideways` is positive to the
        left.
        """
        self._odometry.predict(left, right, sideways)

    @property
    def field(self) -> LikelihoodField | None:
        """Likelihood field of the map with which scans are compared; None without a map."""
        return None

    def extend_map(self, field: LikelihoodField) -> None:
        """Compare scans from now on with another map, whose frame is that of the present map."""

    def change_map(self, field: LikelihoodField, pose: Pose2, covariance: FloatArray) -> None:
        """Change to another map with another frame: set the pose there, and compare scans with that map.

        Args:
            field: likelihood field of the other map.
            pose: pose of the base in the frame of the other map.
            covariance: (3, 3) of the pose along the axes of that frame, in [m, m, rad].
        """
        self._odometry.reset(pose, covariance)
        self.extend_map(field)

    def take_measured(self, pose: Pose2, covariance: FloatArray) -> None:
        """Correct the pose of the resting base by another sensor than wheels and lidar, such as a camera.

        Args:
            pose: measured map_T_base.
            covariance: (3, 3) of the measured pose, in [m, m, rad].
        """
        self._odometry.correct(pose, covariance)

    def deny_wheels(self, pose: Pose2, covariance: FloatArray) -> None:
        """Set a pose that contradicts the wheels; add its difference from the present pose to the covariance.

        Args:
            pose: map_T_base by scans.
            covariance: (3, 3) covariance of the pose on the map before that addition, in [m, m, rad].
        """
        off = pose_difference(self.pose, pose)
        self._odometry.shift(pose, covariance + np.outer(off, off))

    def find_again(self, points: FloatArray) -> bool:
        """Correct the pose if a scan shows that the resting base was moved; return whether it was corrected.

        Args:
            points: (n, 2) end points of the scan in the base frame, in [m].
        """
        return False

    @abstractmethod
    def correct(self, points: FloatArray) -> bool:
        """Correct the pose by scan points (n, 2) in the base frame, in [m]; return whether it was changed."""


class ScanLocalizer(Localizer):
    """Localizer that corrects the odometry of the wheels by matching lidar scans with a map.

    Attributes:
        last_match: match of the latest scan, accepted or not; None before the first.
        expects_echoes: returns whether the map shows enough surfaces for a scan at a pose map_T_base. Where
            it does not, a scan without echoes is no evidence, and only the wheels update the pose.
    """

    STATE: ClassVar[Mapping[str, Any]] = {
        "last_match": ScanMatch | None,
        "_poor": int,
        "_map_error": FloatArray,
        "_by_scans": RestPose | None,
        "_rolled": RolledWay,
        "misplaced": bool,
    }

    def __init__(
        self,
        field: LikelihoodField,
        start: Pose2,
        tread: float,
        errors: OdometryErrors = OdometryErrors(),
        covariance: FloatArray | None = None,
        sigma: float = 0.01,
        least_inliers: float = LEAST_INLIERS,
        patience: int = 10,
    ) -> None:
        """Start at a pose on a map.

        Args:
            field: of the map.
            start: map_T_base.
            tread: distance of the wheels, in [m].
            errors: of the wheels.
            covariance: (3, 3) of the start, in [m, m, rad]; as exact as the map's cells if None.
            sigma: noise of a range, in [m].
            least_inliers: share of points that the map must explain for a match to be believed.
            patience: poor matches in a row after which the robot counts as lost and searches wider.
        """
        super().__init__(start, tread, errors, NUDGE_COVARIANCE if covariance is None else covariance)
        self._field = field
        self._sigma = sigma
        self._least_inliers = least_inliers
        self._patience = patience
        self._poor = 0
        self._map_error = np.zeros((3, 3))  # factor, as in `ScanMatch`
        self._by_scans: RestPose | None = None  # with which scans are compared after `take_measured`
        self.expects_echoes: Callable[[Pose2], bool] = lambda pose: True
        self.misplaced = False
        """True if the first scan contradicts the stated start, but does not reveal the true one."""
        self.slip = SlipMonitor()
        """Monitor of wheels that slip more than assumed."""
        self._rolled = RolledWay()  # in its window
        self.way = WayMonitor()
        """Monitor of travel that is longer or shorter than measured by the wheels."""
        self.last_match: ScanMatch | None = None
        self.unmapped = UnmappedSurroundings(field, sigma)
        """The robot's own keyframes, by which it is located where the map explains too little."""

    @property
    @override
    def field(self) -> LikelihoodField:
        return self._field

    @override
    def extend_map(self, field: LikelihoodField) -> None:
        self._field = field
        self.unmapped = UnmappedSurroundings(field, self._sigma)

    @override
    def change_map(self, field: LikelihoodField, pose: Pose2, covariance: FloatArray) -> None:
        super().change_map(field, pose, covariance)
        self._poor, self._map_error, self.misplaced, self.last_match = 0, np.zeros((3, 3)), False, None
        self._by_scans = None
        self.slip.begin()
        self.way.begin()
        self._rolled = RolledWay()

    @override
    def take_measured(self, pose: Pose2, covariance: FloatArray) -> None:
        self._by_scans = self._by_scans or RestPose(self.pose, remove_part(self.covariance, self.map_error))
        super().take_measured(pose, covariance)
        self._map_error = np.zeros((3, 3))

    @override
    def deny_wheels(self, pose: Pose2, covariance: FloatArray) -> None:
        super().deny_wheels(pose, covariance)
        self._by_scans = None
        self.unmapped.layer.clear()
        self.slip.begin()
        self.way.begin()
        self._rolled = RolledWay()

    @property
    def sure(self) -> bool:
        """True if the last scan matched the map well enough to correct the pose."""
        return self.last_match is not None and self._poor == 0

    @property
    def map_error(self) -> FloatArray:
        """Part of `covariance`, (3, 3) in [m, m, rad] along the map's axes, that comes from the map's errors.

        This error is the same in all poses that are measured at one place.
        """
        return self._map_error @ self._map_error.T

    @override
    def predict(self, left: float, right: float, sideways: float = 0.0) -> None:
        if left == 0.0 and right == 0.0 and sideways == 0.0:
            super().predict(left, right)
            return
        before, errors, tread = self.pose, self._odometry.errors, self._odometry.tread
        self._odometry.slip_factor = self.slip.factor
        super().predict(left, right, sideways)
        by_slip = turn_variance(errors.slip, errors.slip_length, left, right, tread)
        by_slip += self._odometry.sideways_turn_variance(sideways)
        self.slip.roll(left, max(abs(right), abs(sideways)), by_slip)
        slip_variance = errors.slip**2 * self.slip.factor * errors.slip_length
        self.way.roll(0.5 * (left + right), slip_variance * (abs(left) + abs(right)) / 4.0)
        if abs(sideways) > MAX_SIDEWAYS_RATIO * 0.5 * abs(left + right):
            self.way.begin()
        self._rolled = self._rolled.added(left, right, sideways)
        error = self._map_error.copy()  # the one of the last match stays as it is
        error[0] += (before.y - self.pose.y) * error[2]
        error[1] += (self.pose.x - before.x) * error[2]
        self._map_error = error
        if self._by_scans is not None:
            moved = self.pose.relative_to(before)
            self._by_scans = self._by_scans._replace(pose=self._by_scans.pose.compose(moved))

    @property
    def lost(self) -> bool:
        """True if recent scans fit the map at no near pose, or the first scan contradicts the start pose."""
        return self.misplaced or self._poor >= self._patience

    def correct(self, points: FloatArray) -> bool:
        """Correct the pose by a scan if enough of its points fit the map; return whether it was corrected.

        Args:
            points: (n, 2) end points of the scan in the base frame, in [m].
        """
        if len(points) < FEWEST_POINTS:
            self._poor += self.expects_echoes(self.pose)
            return False
        before = self.last_match.evidence if self.last_match and self.sure else None
        match = match_scan(
            self._field, points, self.pose, self.covariance, self._sigma, self.lost, self._map_error, before
        )
        self.last_match, here = match, self.pose
        if match.inliers < self._least_inliers:
            return self._correct_among_unmapped(points)
        self._count_slip(match)
        self._count_way(match)
        self._poor, self._map_error = 0, match.map_error
        self._odometry.correct(match.pose, match.covariance, match.kept)
        self._by_scans = None
        self.unmapped.take(points, here, self.pose, self.covariance)
        return True

    def _correct_among_unmapped(self, points: FloatArray) -> bool:
        """Take over the pose among the robot's own keyframes, corrected by what is left of the map."""
        here = self.pose
        if self.unmapped.layer.empty and not self.unmapped.contradicts(points, here):
            self.unmapped.take(points, here, here, self.covariance)
            return False
        found = self.unmapped.locate(points, here)
        self._poor = self._poor + 1 if found is None else 0
        if found is None:
            return False
        self._by_scans = None
        self._odometry.correct(found.pose, found.covariance, np.eye(3))
        match = self.unmapped.corrected_by_map(points, found, self._map_error)
        if match is not None:
            self._map_error = match.map_error
            self._odometry.correct(match.pose, match.covariance, match.kept)
        self.slip.begin()
        self.way.begin()
        self.unmapped.take(points, found.pose, self.pose, self.covariance)
        return True

    def check_start(self, beams: ScanBeams) -> StartFit:
        """Check by the first scan whether the base is at the pose where it was said to start.

        If the scan fits clearly better at exactly one other place, within `PLAUSIBLE_M`, the pose is set to
        that place. After any other clearly better fit the attribute `misplaced` becomes True.
        """
        noise = math.hypot(self._sigma, CELL_SIGMA * self._field.map.resolution)
        fit = check_start(self._field, beams, self.pose, noise)
        if fit.other is not None and fit.is_sure:
            self.relocalize(fit.other, beams.points)
        self.misplaced = fit.contradicts and not fit.is_sure
        return fit

    def _count_slip(self, match: ScanMatch) -> None:
        """Compare the turn that the wheels missed with the assumed slip, if the scan alone determines it."""
        if match.kept[2, 2] > SCANS_TELL or self._poor:
            self.slip.begin()
        else:
            missed = wrap(float(match.pose.theta - self.pose.theta))
            self.slip.take(missed, self._odometry.turn_variance(*self._rolled))
        if self.slip.begun:
            self._rolled = RolledWay()

    def _count_way(self, match: ScanMatch) -> None:
        """Compare the travel with the wheels' measurement, if the scan alone determines it."""
        cos, sin = math.cos(self.pose.theta), math.sin(self.pose.theta)
        (xx, xy, _), (yx, yy, _), _ = match.kept.tolist()
        if cos * (xx * cos + xy * sin) + sin * (yx * cos + yy * sin) > SCANS_TELL or self._poor:
            self.way.begin()
            return
        missed = cos * (match.pose.x - self.pose.x) + sin * (match.pose.y - self.pose.y)
        map_sigma = math.hypot(*(cos * match.map_error[0] + sin * match.map_error[1]).tolist())
        wrong = self.way.take(missed, map_sigma, self._odometry.scale_variance)
        if wrong:
            self._odometry.doubt_scale(wrong)

    def find_again(self, points: FloatArray) -> bool:
        """Search the pose of a base that was moved by up to about 0.3 m and 10 degrees; return True if found.

        Args:
            points: (n, 2) end points of a scan in the base frame, in [m].
        """
        if len(points) < FEWEST_POINTS:
            return False
        # the map errs alike in both poses
        before = self._by_scans or RestPose(self.pose, remove_part(self.covariance, self.map_error))
        near = np.asarray(self.covariance + NUDGE_COVARIANCE)
        match = match_scan(self._field, points, self.pose, near, self._sigma)
        if self.last_match is None or match.inliers < MIN_SHARE_KEPT_AT_REST * self.last_match.inliers:
            match = match_scan(self._field, points, self.pose, SEARCH_COVARIANCE, self._sigma, anneal=True)
        spread = match.spread + before.covariance
        moved = is_apart(before.pose, match, spread, self._field, self.surface_error)
        if not moved or match.inliers < self._least_inliers:
            return False
        self.relocalize(self.pose, points)
        return True

    def relocalize(self, near: Pose2, points: FloatArray) -> ScanMatch:
        """Set the pose to the best match of a scan near a rough pose; return the match.

        The rough pose may be off by up to about 0.3 m and 10 degrees.

        Args:
            near: rough map_T_base.
            points: (n, 2) end points of the scan in the base frame, in [m].
        """
        match = match_scan(self._field, points, near, SEARCH_COVARIANCE, self._sigma, anneal=True)
        self._odometry.reset(match.pose, match.covariance)
        self.unmapped.layer.clear()
        self.last_match, self._poor, self._map_error, self._by_scans = match, 0, match.map_error, None
        return match
