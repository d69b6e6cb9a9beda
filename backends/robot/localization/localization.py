"""Interface of localizations, and the usual ones: scan matching and wheels."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from handcart.backends.backend import Backend
from handcart.backends.capabilities.base import Base, WheelTravel
from handcart.backends.capabilities.gps import Fix
from handcart.backends.capabilities.range_sensor import RangeSensor
from handcart.backends.plain_values import Kinds, attributes, from_plain, set_attributes
from handcart.backends.saved_state import NotAState
from handcart.robotics.far import FarArray
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.localization.likelihood_field import LikelihoodField
from handcart.robotics.navigation.localization.localizer import (
    LEAST_INLIERS,
    Localizer,
    OdometryLocalizer,
    ScanLocalizer,
)
from handcart.robotics.navigation.localization.start_search import SURE_FIT, ScanBeams
from handcart.robotics.navigation.localization.watched_moment import Belief
from handcart.robotics.navigation.locating.local_map import LocalMap
from handcart.robotics.navigation.locating.scan_jump import MAX_CHANGED_SHARE, ScanJump

from .lidar import MIN_ECHOES, Lidar

STILL_SCANS = 20  # periods at rest after which further scans tell nothing new
LOOK_AGAIN = 10  # periods at rest between scans that tell whether somebody moved the base
SCAN_REPEATABILITY = np.diag([0.004, 0.004, 0.0015]) ** 2  # [m², rad²]: scatter of scan matches at one place
# [m] by which encoders of wheels that stand differ, as an arm pulls at the base
MAX_REST_WHEEL_DIFFERENCE_M = 2e-4
STALE_SCAN_MOTION = 1e-3  # [m], [rad] of motion in which a scan can't stay the same to the last bit
REST_PERIODS = 4  # periods at rest after which a scan tells whether the base is where its wheels say
# [m] that wheels may be driven, by which alone it is reckoned, while they read the same
MAX_COMMANDED_TRAVEL_M = 0.03
LIFTED_REASON = "it was lifted and set down elsewhere: its scans changed at once, and its wheels did not turn"
DRAWN_SURFACE_M = 0.03  # error of surfaces that are drawn from several scans
LIFTED_KEY = "lifted"  # of a state, where the base was lifted
LOCAL_MAP_KEY = "local map"  # of a state, where the pose on the map is unknown


class Lost(NamedTuple):
    """Why it isn't known where the base is."""

    why: str
    """Reason, as text."""
    sensor: str
    """Capability that no longer determines the pose."""
    what: str
    """Name of the deciding quantity."""
    value: float
    limit: float
    unit: str = ""


class Sensed(NamedTuple):
    """Outdoor readings of the last period."""

    rates: NDArray[np.float64]
    """(3,) of the gyros, in [rad/s]."""
    accelerations: NDArray[np.float64]
    """(3,) in [m/s²]."""
    rolled: NDArray[np.float64]
    """(2,) by the left and right wheel, in [m]."""
    fix: Fix | None
    ranges: NDArray[np.float64] | None = None
    """(k,) to the beacons, in [m]; NaN of those that weren't heard."""


class Localization(ABC):
    """Estimates map_T_base once a period, and detects that a base at rest was moved."""

    STATE: ClassVar[Kinds] = {
        "displacements": int,
        "travel": WheelTravel,
        "still": int,
        "_stood": WheelTravel,
        "_ranges": FarArray,
        "_seen_at": WheelTravel,
    }
    """Attributes that a checkpoint keeps, with their types."""
    POSE_JUMPS: ClassVar[bool] = False
    """True if `pose` jumps by more than the base moves as the estimate improves; `odometry_pose` does not."""

    def __init__(self, backend: Backend, wheels: Localizer, lidar: RangeSensor | None = None) -> None:
        """Begin with a robot at rest; `wheels` propagates the pose, `lidar` returns interpreted scans."""
        self._wheels, self._range_sensor = wheels, lidar
        base = backend.get(Base)  # type: ignore[type-abstract]
        assert base is not None, "a robot has wheels"
        self._base = base
        self.displacements = 0
        """Number of times that a base at rest was found elsewhere."""
        self.travel = base.wheel_travel()
        """Travel of the wheels."""
        self.still = 0
        """Number of periods in which the wheels were at rest, apart from deflection."""
        self._stood = self.travel  # what the wheels had travelled when they last turned
        self._ranges, self._seen_at = np.empty(0), self.travel
        self._map_field: LikelihoodField | None = None
        """Field of the given map; None if no scan is compared with a map."""
        self.lifted: Lost | None = None
        """Evidence that the base was lifted and set down elsewhere; None if it was not, or is located
        since.
        """
        self._scan_jump = ScanJump()
        self.local_map: LocalMap | None = None
        """Map drawn since the pose on the given map is unknown; None while that pose is known."""

    # What is estimated

    @property
    def pose(self) -> Pose2:
        """map_T_base."""
        return self._wheels.pose

    @property
    def is_located(self) -> bool:
        """True if `pose` is on the map; False if it is in a local frame, because the start is unknown."""
        return self.local_map is None

    @property
    def can_relocate(self) -> bool:
        """True if `forget_pose` and `locate` can be used: scans are compared with a map."""
        return self._map_field is not None and isinstance(self._range_sensor, Lidar)

    @property
    def odometry_pose(self) -> Pose2:
        """Pose of the base without jumps, in a frame of its own if `pose` jumps; otherwise `pose`."""
        return self.pose

    def set_origin(self) -> None:
        """Start measuring `displacement` here."""
        self._wheels.odometry.set_origin()

    @property
    def displacement(self) -> Belief | None:
        """Motion of the base since `set_origin`; None where two poses alone can be compared.

        Ahead and left in [m], and turn in [rad]: mean (3,) and covariance (3, 3).
        """
        return self._wheels.odometry.displacement

    @property
    def covariance(self) -> NDArray[np.float64]:
        """(3, 3) of x, y in [m] and heading in [rad]."""
        return self._wheels.covariance

    @property
    def particles(self) -> NDArray[np.float64] | None:
        """(3, n) x, y in [m], heading in [rad] of poses that it holds possible; None where it has none."""
        return None

    @property
    def repeatability(self) -> NDArray[np.float64]:
        """(3, 3) covariance of a pose compared with another one measured at the same place.

        Of x, y in [m] and heading in [rad], on the map. The map's error, which both poses share, is
        excluded. It is never less than the noise of the sensors; along a direction that they do not
        determine it is as large as `covariance`.
        """
        return self.covariance

    @property
    def sigma(self) -> tuple[float, float]:
        """Sigma of `repeatability` along its worst direction in [m], and of the heading in [rad].

        Infinite while the robot is lost.
        """
        return (math.inf, math.inf) if self.lost is not None else worst_sigmas(self.repeatability)

    @property
    def tilt(self) -> tuple[float, float]:
        """Roll and pitch of the base in [rad]; zero if unmeasured."""
        return 0.0, 0.0

    @property
    def lost(self) -> Lost | None:
        """Why it isn't known any more where the base is; None while it is."""
        return None

    @property
    def heading_known(self) -> bool:
        """True if the heading is known."""
        return True

    @property
    def doubt(self) -> Lost | None:
        """Why what it claims about where it is isn't to be relied on just now; None while it is."""
        return self.lost

    @property
    def slips(self) -> int:
        """Number of scans at rest that contradicted the wheels' pose after a drive."""
        return 0

    @property
    def added_sigma(self) -> float:
        """Sigma in [m] that the drive has added to the pose, and that a scan at rest takes away."""
        return 0.0

    @property
    def sensed(self) -> Sensed | None:
        """Outdoor readings of the last period; None indoors."""
        return None

    @property
    def explained(self) -> float:
        """Share of the last scan's points that the map explains; NaN where no scan is compared with it."""
        return float("nan")

    @property
    @abstractmethod
    def source(self) -> str:
        """Name of the capability that determines the pose."""

    @property
    @abstractmethod
    def dead_reckoned(self) -> bool:
        """True if only wheels or gyros measure the base's motion."""

    # What happens

    def update(self, driven: tuple[float, float]) -> None:
        """A period has passed: take in what was sensed in it.

        Args:
            driven: speed in [m/s] and turn rate in [rad/s] that the base was commanded in it.
        """
        travel = self._base.wheel_travel()
        if not (math.isfinite(travel.left) and math.isfinite(travel.right)):
            travel = self.travel  # the next sound reading has it all
        left, right = travel.left - self.travel.left, travel.right - self.travel.right
        self.travel = travel
        self._predict(left, right)
        self._watch_lifting(left, right)
        self._extend_local_map()
        if travel.away(self._stood) <= MAX_REST_WHEEL_DIFFERENCE_M:
            self.still += 1
            if self.still == STILL_SCANS:
                self._stood = travel  # it has come to rest
        else:
            self._stood = travel
            self.look_again()  # a roll must not hide that the base no longer stood where it stood
            self.still = 0
        self._correct()

    def look_again(self) -> None:
        """At rest, check whether the base is still at its pose; if not, find the new one."""
        if self.still <= STILL_SCANS or self._range_sensor is None:
            return
        if self._wheels.find_again(self._fresh_points()):
            self._displaced()

    def found_at(self, pose: Pose2, sigma: tuple[float, float]) -> None:
        """Correct the pose by a measured map_T_base, with its sigma in [m] and in [rad]."""
        variance = np.diag([sigma[0], sigma[0], sigma[1]]) ** 2
        self._wheels.odometry.correct(pose, variance)

    def forget_pose(self) -> None:
        """Estimate poses in a local frame from now on, compared with what the lidar shows from here on.

        The frame is such that `pose` does not change.
        """
        assert self._map_field is not None
        assert isinstance(self._range_sensor, Lidar)
        self.local_map, self.lifted = LocalMap(), None
        self.local_map.add(self.pose, beams_of(self._range_sensor))
        self._wheels.change_map(self.local_map.field, self.pose, SCAN_REPEATABILITY)
        self._wheels.surface_error = DRAWN_SURFACE_M
        self.still = 0
        self.set_origin()

    def locate(self, pose: Pose2, covariance: NDArray[np.float64]) -> None:
        """Take over map_T_base with its covariance (3, 3), in [m, m, rad]: the pose on the map is known."""
        assert self._map_field is not None
        self.local_map = self.lifted = None
        self._wheels.change_map(self._map_field, pose, covariance)
        self._wheels.surface_error = 0.0
        self.still = 0
        self.set_origin()

    def _watch_lifting(self, left: float, right: float) -> None:
        """Compare this period's scan with the one before; the wheels travelled this far, in [m]."""
        lidar = self._range_sensor
        if self._map_field is None or not isinstance(lidar, Lidar) or self.lifted is not None:
            return
        self._scan_jump.roll(left, right, self._wheels.odometry.tread)
        rests = self.still > STILL_SCANS
        if (rests and self.still % LOOK_AGAIN != 0) or lidar.silence:
            return
        if self._scan_jump.take(beams_of(lidar), rests):
            self.lifted = _lifted(self._scan_jump.share)
            self._displaced()

    def _extend_local_map(self) -> None:
        """Draw this period's scan on the local map where the base has not been yet."""
        local, lidar = self.local_map, self._range_sensor
        if local is None or not isinstance(lidar, Lidar) or self.lost is not None:
            return
        if local.is_due(self.pose) and not lidar.silence:
            local.add(self.pose, beams_of(lidar))
            self._wheels.extend_map(local.field)

    def mark(self) -> None:
        """Mark this moment for `smoothed`."""

    def smoothed(self) -> list[Belief]:
        """Return the poses at the marked moments by all readings before and after; empty if smoothing adds
        nothing.
        """
        return []

    def _predict(self, left: float, right: float) -> None:
        """The wheels travelled this far, in [m]."""
        self._wheels.predict(left, right)

    def _correct(self) -> None:
        """Correct the pose by scans, as long as they add information."""
        if self._range_sensor is None:
            return
        if self.still <= STILL_SCANS:
            self._wheels.correct(self._fresh_points())
        elif self.still % LOOK_AGAIN == 0:
            self.look_again()

    def _displaced(self) -> None:
        self.displacements += 1
        self.still = 0

    def _fresh_points(self) -> NDArray[np.float64]:
        """(n, 2) in [m] of this period's scan; none if it is stale: the same although the wheels rolled."""
        assert self._range_sensor is not None
        scan = self._range_sensor.scan()
        if not np.array_equal(scan.ranges, self._ranges):
            self._ranges, self._seen_at = scan.ranges.copy(), self.travel
        return np.empty((0, 2)) if self.travel.away(self._seen_at) > STALE_SCAN_MOTION else scan.points()

    # For a checkpoint

    def state(self) -> dict[str, Any]:
        """Return the estimates so far, as plain data."""
        state: dict[str, Any] = {
            name: attributes(part, kinds) for name, (part, kinds) in self._parts().items()
        }
        if self.local_map is not None:
            state[LOCAL_MAP_KEY] = self.local_map.echoes.ravel().tolist()
        if self.lifted is not None:
            state[LIFTED_KEY] = self.lifted.value
        return state

    def set_state(self, state: object) -> None:
        """Restore the estimates returned by `state`.

        Raises:
            NotAState: the data belong to another kind of localization.
        """
        parts = self._parts()
        if not isinstance(state, dict) or state.keys() - {LOCAL_MAP_KEY, LIFTED_KEY} != parts.keys():
            raise NotAState(f"no state of this localization; needed: {', '.join(parts)}")
        for name, (part, kinds) in parts.items():
            set_attributes(part, kinds, state[name])
        self._set_local_map(state.get(LOCAL_MAP_KEY))
        share = from_plain(state.get(LIFTED_KEY, 0.0), float, LIFTED_KEY)
        self.lifted = _lifted(share) if share else None
        self._scan_jump.reset()

    def _set_local_map(self, echoes: object) -> None:
        """Restore whether the pose on the map is known; `echoes` are those of the local map, if it is not."""
        if echoes is None:
            self.local_map = None
            self._wheels.surface_error = 0.0
            if self._map_field is not None:
                self._wheels.extend_map(self._map_field)
            return
        if not self.can_relocate:
            raise NotAState("no state of this localization: it needs a map and a lidar")
        flat = from_plain(echoes, list[float], LOCAL_MAP_KEY)
        if len(flat) % 2:
            raise NotAState(f"no saved state: {LOCAL_MAP_KEY}: pairs of numbers are needed")
        self.local_map = LocalMap.of_echoes(np.array(flat).reshape(-1, 2), self.pose)
        self._wheels.extend_map(self.local_map.field)
        self._wheels.surface_error = DRAWN_SURFACE_M

    def _parts(self) -> dict[str, tuple[object, Kinds]]:
        """Return the parts that change in a run."""
        return {
            "localization": (self, self.STATE),
            "wheels": (self._wheels, self._wheels.STATE),
            "odometry": (self._wheels.odometry, self._wheels.odometry.STATE),
        }


class ScanLocalization(Localization):
    """Wheels carry the pose on, scans correct it."""

    STATE: ClassVar[Kinds] = {**Localization.STATE, "_map_error_then": NDArray[np.float64]}

    def __init__(self, backend: Backend, matching: ScanLocalizer, lidar: RangeSensor | None) -> None:
        """Begin with a robot at rest, and match a scan at once."""
        super().__init__(backend, matching, lidar)
        self._matching, self._map_error_then = matching, np.zeros((3, 3))
        self._map_field = matching.field
        assert self._range_sensor is not None, "scans come from a range sensor"
        matching.correct(self._range_sensor.scan().points())
        if isinstance(lidar, Lidar):
            matching.check_start(beams_of(lidar))
        self.set_origin()

    @property
    @override
    def repeatability(self) -> NDArray[np.float64]:
        return repeatability_of(self.covariance, self._matching.map_error)

    @property
    def displacement(self) -> Belief:
        """See `Localization`: the error of the map at one place is the same in both poses."""
        mean, spread = self._matching.odometry.displacement
        shared = self._map_error_then + self._matching.map_error
        turned = _turned(self._matching.odometry.origin.theta)
        return Belief(mean, _without(spread, turned @ shared @ turned.T) + 2.0 * SCAN_REPEATABILITY)

    @override
    def set_origin(self) -> None:
        super().set_origin()
        self._map_error_then = self._matching.map_error

    @property
    @override
    def source(self) -> str:
        return "RangeSensor"

    @property
    @override
    def dead_reckoned(self) -> bool:
        return False

    @property
    @override
    def lost(self) -> Lost | None:
        if self.lifted is not None:
            return self.lifted
        if not self._matching.lost:
            return None
        share = "share of the scan that the map explains"
        silence = self._range_sensor.silence if isinstance(self._range_sensor, Lidar) else ""
        if silence:
            echoes = float(len(self._range_sensor.scan().points())) if self._range_sensor else 0.0
            return Lost(silence, "RangeSensor", "beams of a scan that return", echoes, float(MIN_ECHOES))
        if self._matching.misplaced:
            why = "it isn't where it should start: its scan fits other places of the map better"
            return Lost(why, "RangeSensor", share, self.explained, SURE_FIT)
        return Lost("its scans fit the map nowhere near", "RangeSensor", share, self.explained, LEAST_INLIERS)

    @property
    @override
    def explained(self) -> float:
        match = self._matching.last_match
        return super().explained if match is None else match.inliers

    def _parts(self) -> dict[str, tuple[object, Kinds]]:
        slip, way, layer = self._matching.slip, self._matching.way, self._matching.unmapped.layer
        parts = super()._parts()
        parts |= {"slip": (slip, slip.STATE), "way": (way, way.STATE)}
        return {**parts, "keyframes": (layer, layer.STATE)}

    @override
    def set_state(self, state: object) -> None:
        layer = self._matching.unmapped.layer
        layer.clear()
        if isinstance(state, dict) and "keyframes" not in state:  # older checkpoints have none
            state = {**state, "keyframes": attributes(layer, layer.STATE)}
        super().set_state(state)


class WheelLocalization(Localization):
    """Propagates the pose by the wheels. With a map and a lidar, scans at rest are evidence.

    Scans show whether the base was moved while its wheels were at rest, and its pose after each drive. If
    no close pose explains the scan, the base is lost.

    If driven wheels repeat their readings, either the wheels or the encoders are stuck: the two cannot be
    distinguished, so the pose is unknown.
    """

    STATE: ClassVar[Kinds] = {**Localization.STATE, "_unanswered": float}

    def __init__(self, backend: Backend, wheels: OdometryLocalizer, lidar: RangeSensor | None = None) -> None:
        """Begin with a robot at rest."""
        super().__init__(backend, wheels, lidar)
        self._reckoning = wheels
        self._map_field = wheels.field
        self._period, self._unanswered = backend.period, 0.0

    @property
    @override
    def source(self) -> str:
        return "Base"

    @property
    @override
    def dead_reckoned(self) -> bool:
        return True

    @property
    @override
    def lost(self) -> Lost | None:
        if self.lifted is not None:
            return self.lifted
        if self._reckoning.astray:
            share = "share of the scan that the map explains"
            why = "after the drive its scan fits the map nowhere near where its wheels say"
            return Lost(why, "RangeSensor", share, self._reckoning.explained, LEAST_INLIERS)
        if self._unanswered <= MAX_COMMANDED_TRAVEL_M:
            return None
        why = "its wheels are driven, and read the same again and again"
        way = "way driven since the wheels read anything new"
        return Lost(why, "Base", way, 1e3 * self._unanswered, 1e3 * MAX_COMMANDED_TRAVEL_M, "mm")

    @property
    @override
    def slips(self) -> int:
        return self._reckoning.slips

    @property
    @override
    def added_sigma(self) -> float:
        return self._reckoning.added_sigma

    def look_again(self) -> None:
        """See `Localization`; after a drive, first compare the wheels' pose with a scan."""
        if self._reckoning.unchecked and self.still >= REST_PERIODS and self._range_sensor is not None:
            self._reckoning.check_drive(self._fresh_points())
        super().look_again()

    def _correct(self) -> None:
        if self.still == REST_PERIODS:
            self.look_again()
        super()._correct()

    @override
    def update(self, driven: tuple[float, float]) -> None:
        before = self.travel
        super().update(driven)
        speed, turn_rate = driven
        way = (abs(speed) + 0.5 * self._wheels.odometry.tread * abs(turn_rate)) * self._period
        self._unanswered = self._unanswered + way if self.travel == before else 0.0


def worst_sigmas(covariance: NDArray[np.float64]) -> tuple[float, float]:
    """Return the sigma of a position along its worst direction in [m], and of the heading in [rad].

    Args:
        covariance: (3, 3) of x, y in [m] and heading in [rad].
    """
    (xx, _, _), (xy, yy, _), (_, _, turn) = covariance.tolist()
    worst = 0.5 * (xx + yy) + math.hypot(0.5 * (xx - yy), xy)
    return math.sqrt(max(0.0, worst)), math.sqrt(max(0.0, turn))


def repeatability_of(covariance: NDArray[np.float64], map_error: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return `Localization.repeatability` (3, 3) of a pose by scans, `map_error` (3, 3) in its covariance."""
    return np.asarray(_without(covariance, map_error) + SCAN_REPEATABILITY)


def _lifted(share: float) -> Lost:
    """Return that the base was lifted, by the share of beams that changed at once."""
    what = "share of beams that changed at once"
    return Lost(LIFTED_REASON, "RangeSensor", what, share, MAX_CHANGED_SHARE)


def beams_of(lidar: Lidar) -> ScanBeams:
    """Return this period's scan by its beams, without blind ones."""
    scan = lidar.scan()
    sensor = scan.base_T_sensor
    ranges = np.where(scan.blind(), np.nan, scan.ranges) if len(scan.validity) else scan.ranges
    return ScanBeams(np.array([sensor.x, sensor.y]), scan.angles + sensor.theta, ranges, lidar.spec.reach_m)


def _without(covariance: NDArray[np.float64], part: NDArray[np.float64]) -> NDArray[np.float64]:
    """Subtract a part (3, 3) of a covariance (3, 3); no variance of what is left is negative."""
    rest = covariance - part
    if _is_positive(rest):
        return rest
    variances, axes = np.linalg.eigh(rest)
    return np.asarray((axes * np.maximum(variances, 0.0)) @ axes.T)


def _is_positive(matrix: NDArray[np.float64]) -> bool:
    """Return whether a symmetric matrix (3, 3) has no variance of 0 or below: its leading minors."""
    (a, _, _), (b, c, _), (d, e, f) = matrix.tolist()
    minor = a * c - b * b
    return bool(a > 0.0 and minor > 0.0 and f * minor > a * e * e - 2.0 * b * d * e + c * d * d)


def _turned(heading: float) -> NDArray[np.float64]:
    """(3, 3) rotation from the map to the frame of a base with that heading, in [rad]."""
    cos, sin = math.cos(heading), math.sin(heading)
    return np.array([[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]])
