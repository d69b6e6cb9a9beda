"""Interface of localizations, with what scans at rest show."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from typing import Any, ClassVar

import numpy as np

from handcart.backends.backend import Backend
from handcart.backends.capabilities.base import Base, DriveCommand, WheelTravel
from handcart.backends.capabilities.range_sensor import RangeSensor, Scan
from handcart.backends.plain_values import Kinds, attributes, from_plain, set_attributes
from handcart.backends.saved_state import NotAState
from handcart.robotics.far import FarArray
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.localization.localizer import Localizer
from handcart.robotics.navigation.locating.local_map import LocalMap
from handcart.robotics.navigation.odometry.watched_moment import Belief
from handcart.robotics.navigation.scans.likelihood_field import LikelihoodField
from handcart.robotics.numerics.arrays import FloatArray

from .crowd import Crowd
from .held_base import HeldBase
from .lidar import MIN_ECHOES, Lidar, beams_of
from .lift_watch import LOOK_AGAIN, LiftWatch
from .lost import Lost, lifted_by
from .older_states import completed, local_map_of
from .pose_covariance import SCAN_REPEATABILITY, worst_sigmas
from .sensed import Sensed

STILL_SCANS = 20  # periods at rest after which further scans add no information
# [m] between encoders of wheels at rest, as an arm pulls at the base
MAX_REST_WHEEL_DIFFERENCE_M = 2e-4
STALE_SCAN_MOTION = 1e-3  # [m], [rad] of motion in which a scan can't stay the same to the last bit
DRAWN_SURFACE_M = 0.03  # error of surfaces that are drawn from several scans
LIFTED_KEY = "lifted"  # of a state, where the base was lifted
LOCAL_MAP_KEY = "local map"  # of a state, where the pose on the map is unknown


class Localization(ABC):
    """Estimator of map_T_base, updated once a period, that also detects that a base at rest was moved."""

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
        """Travel of the wheels by their encoders, in [m]."""
        self.still = 0
        """Number of periods in which the wheels were at rest, apart from deflection."""
        self._stood = self.travel  # travel of the wheels when they last turned
        self._ranges, self._seen_at = np.empty(0), self.travel
        self._noted: Scan | None = None  # of the last period in which the wheels rolled
        self._period, self.stale_s = backend.period, 0.0
        """Time for which the lidar has repeated a scan although the base moved, in [s]."""
        self.crowd = Crowd()
        """People around the base."""
        self.map_field: LikelihoodField | None = None
        """Field of the given map; None if no scan is compared with a map."""
        self.lifted: Lost | None = None
        """Evidence that the base was lifted and set down elsewhere; None before, and since it is located."""
        self.lift_watch = LiftWatch(wheels.odometry.tread)
        self.held_base = HeldBase(wheels, None, backend.period)
        """Watch for wheels that turn while something holds the base."""
        self.local_map: LocalMap | None = None
        """Map drawn since the pose on the given map is unknown; None while that pose is known."""

    # Estimates

    @property
    def pose(self) -> Pose2:
        """Estimated 2D pose map_T_base."""
        return self._wheels.pose

    @property
    def is_located(self) -> bool:
        """True if `pose` is on the task's map; False if it is unknown there and refers to a local map."""
        return self.local_map is None

    @property
    def can_relocate(self) -> bool:
        """True if the robot has a map and a lidar, so that a lost pose can be searched again on the map."""
        return self.map_field is not None and isinstance(self._range_sensor, Lidar)

    @property
    def odometry_pose(self) -> Pose2:
        """2D pose of the base that never jumps, indoors `pose`, outdoors dead reckoning in its own frame."""
        return self.pose

    def set_origin(self) -> None:
        """Set the base's current pose as the pose from which `displacement` measures the motion."""
        self._wheels.odometry.set_origin()

    @property
    def displacement(self) -> Belief | None:
        """Motion of the base since the call of `set_origin`; None if the localization does not measure it.

        Mean (3,) and covariance (3, 3): ahead and to the left in [m], turn to the left in [rad].
        """
        return self._wheels.odometry.displacement

    @property
    def covariance(self) -> FloatArray:
        """Covariance (3, 3) of the pose: x and y on the map in [m], heading in [rad]."""
        return self._wheels.covariance

    @property
    def particles(self) -> FloatArray | None:
        """Poses (3, n) on the map, rows x, y in [m] and heading in [rad]; None without a particle filter."""
        return None

    @property
    def repeatability(self) -> FloatArray:
        """Covariance (3, 3) of the pose relative to another pose estimated at the same place.

        x, y on the map in [m], heading in [rad], without the map's error, which both poses share. It is never
        below the sensors' noise, and equals `covariance` along a direction that the sensors do not determine.
        """
        return self.covariance

    @property
    def map_shift(self) -> FloatArray:
        """Largest errors of the position on the map due to the size of the map's cells, in [m], without sign.

        The errors along x and y (2,), or (1 + n, 2) with a further row for each of n directions of walls.
        They are added to `repeatability` when a pose is compared with a place on the map.
        """
        return np.zeros(2)

    @property
    def sigma(self) -> tuple[float, float]:
        """Standard deviations of position (worst axis) in [m] and heading in [rad]; infinite if lost."""
        return (math.inf, math.inf) if self.lost is not None else worst_sigmas(self.repeatability)

    @property
    def tilt(self) -> tuple[float, float]:
        """Roll and pitch of the base in [rad]; zero if unmeasured."""
        return 0.0, 0.0

    @property
    def lost(self) -> Lost | None:
        """Reason why the base's pose is unknown; None while it is known."""
        return None

    @property
    def heading_known(self) -> bool:
        """True if the heading in the world is known; before that, only the motion is estimated."""
        return True

    @property
    def doubt(self) -> Lost | None:
        """Reason why `covariance` cannot be relied on at the moment; None while it is reliable."""
        return self.lost

    @property
    def slips(self) -> int:
        """Number of drives after which a scan of the resting base contradicted the pose by the wheels."""
        return 0

    @property
    def added_sigma(self) -> float:
        """Standard deviation, in [m], of position error that driving added since the last scan at rest."""
        return 0.0

    @property
    def sensed(self) -> Sensed | None:
        """Readings of wheels, IMU, satellite fix and beacons in the last control period; None indoors."""
        return None

    @property
    def explained(self) -> float:
        """Share (0 to 1) of points of the last compared scan that agree with the map; NaN without a scan."""
        return float("nan")

    @property
    @abstractmethod
    def source(self) -> str:
        """Name of the capability, such as `RangeSensor`, that determines the pose."""

    @property
    @abstractmethod
    def dead_reckoned(self) -> bool:
        """True if now only wheels or gyros measure the motion, and no sensor measures the position."""

    def update(self, driven: DriveCommand) -> None:
        """Update the estimate with the readings of the period that has passed.

        Args:
            driven: command of the base in that period.
        """
        travel = self._base.wheel_travel()
        travel = travel if all(map(math.isfinite, travel)) else self.travel  # the next sound one has it all
        rolled = WheelTravel(*(now - then for now, then in zip(travel, self.travel, strict=True)))
        self.travel, before = travel, self.pose
        self._predict(*rolled)
        self._note_scan(any(rolled))
        self._watch_scans(rolled)
        self._extend_local_map()
        if travel.away(self._stood) <= MAX_REST_WHEEL_DIFFERENCE_M:
            self.still += 1
            if self.still == STILL_SCANS:
                self._stood = travel  # it has come to rest
                if self._range_sensor is not None:
                    self.crowd.came_to_rest(self._range_sensor.scan())
        else:
            self._stood = travel
            self.look_again(self.pose.relative_to(before))  # a roll must not hide a push before it
            self.still = 0
            self.crowd.moved()
        self._correct()
        self.crowd.passed()
        self.held_base.note_pose(self._is_found)

    def look_again(self, rolled: Pose2 = Pose2(0.0, 0.0, 0.0)) -> None:
        """Find the pose again if a scan shows that the base was moved; `rolled` is the wheels' motion."""
        if self.still <= STILL_SCANS or self._range_sensor is None:
            return
        points, scan = self._fresh_points(), self._range_sensor.scan()
        hidden = self.crowd.hides_walls(scan, self.pose, self.map_field, rolled)
        if not hidden and self._wheels.find_again(points):
            self._displaced()

    def found_at(self, pose: Pose2, sigma: tuple[float, float]) -> None:
        """Correct the pose by a measured map_T_base with the sigmas of x and y [m] and heading [rad]."""
        variance = np.diag([sigma[0], sigma[0], sigma[1]]) ** 2
        self._wheels.take_measured(pose, variance)

    def forget_pose(self) -> None:
        """Discard the pose, and estimate it on a new local map of the present scan and later ones."""
        assert self.map_field is not None
        assert isinstance(self._range_sensor, Lidar)
        self.local_map, self.lifted = LocalMap(), None
        self.local_map.add(self.pose, beams_of(self._range_sensor))
        self._wheels.change_map(self.local_map.field, self.pose, SCAN_REPEATABILITY)
        self._wheels.surface_error, self.still = DRAWN_SURFACE_M, 0
        self.held_base.reset()
        self.set_origin()

    def locate(self, pose: Pose2, covariance: FloatArray) -> None:
        """Localize on the task's map, not the local one, from `pose`; `covariance` (3, 3): [m, m, rad]."""
        assert self.map_field is not None
        self.local_map = self.lifted = None
        self._wheels.change_map(self.map_field, pose, covariance)
        self._wheels.surface_error, self.still = 0.0, 0
        self.held_base.reset()
        self.set_origin()

    def follow_map(self, field: LikelihoodField, pose: Pose2, covariance: FloatArray) -> None:
        """Match scans with a new map that was drawn from scans. `pose` is map_T_base on this map, with its
        covariance (3, 3) of x, y in [m] and heading in [rad].
        """
        self.map_field = field
        self._wheels.change_map(field, pose, covariance)
        self._wheels.surface_error, self.still = DRAWN_SURFACE_M, 0
        self.held_base.reset()

    def measure_displacement(self, displacement: Pose2, covariance: FloatArray) -> None:
        """Correct the resting base's pose by a measured motion since `set_origin` (origin_T_base), with
        covariance (3, 3) of x, y [m] and heading [rad]; until the base drives, scans only detect pushes.
        """
        self._wheels.odometry.measure_displacement(displacement, covariance)
        self.still = STILL_SCANS + 1

    def _watch_scans(self, rolled: WheelTravel) -> None:
        """Compare this period's scan with earlier ones; the wheels travelled `rolled` [m] in the period."""
        if self.held_base.update(rolled, self.still):
            self.lift_watch.reset()
            self.crowd = Crowd()
        lidar = self._range_sensor
        if self.map_field is None or not isinstance(lidar, Lidar) or self.lifted is not None:
            return
        if (lifted := self.lift_watch.take(lidar, rolled, self.still, self.crowd, self.pose)) is not None:
            self.lifted = lifted
            self._displaced()

    def _extend_local_map(self) -> None:
        """Draw this period's scan on the local map where the base has not been yet."""
        local, lidar = self.local_map, self._range_sensor
        if local is None or not isinstance(lidar, Lidar) or self.lost is not None:
            return
        if local.is_due(self.pose) and not lidar.silence:
            local.add(self.pose, beams_of(lidar))
            self._wheels.extend_map(local.field)

    @property
    def _is_found(self) -> bool:
        """True if a scan shows where the base is."""
        return True

    def mark(self) -> None:
        """Mark the present instant, so that `smoothed` returns the pose at this instant."""

    def smoothed(self) -> list[Belief]:
        """Return the poses at times marked by `mark`, corrected by later readings; empty if indoors."""
        return []

    def _predict(self, left: float, right: float, sideways: float) -> None:
        """Predict the motion from the wheels' travel in this period, in [m]; sideways is to the left."""
        self._wheels.predict(left, right, sideways)

    def _note_scan(self, rolls: bool) -> None:
        """Note whether the lidar repeats its scan; `rolls`: the wheels rolled in this period."""
        if self._range_sensor is not None and (rolls or self.stale_s > 0.0):
            scan = self._range_sensor.scan()
            repeats = scan is self._noted or len(scan.points()) >= MIN_ECHOES  # new empty scans are alike
            self.stale_s = self.stale_s + self._period if self._is_stale(scan) and repeats else 0.0
            self._noted = scan

    def _correct(self) -> None:
        """Correct the pose by scans, as long as they add information; repeated ones add none."""
        if self._range_sensor is None or self.stale_s > 0.0:
            return
        if self.still <= STILL_SCANS:
            if self._wheels.CORRECTS_BY_SCANS:
                self._wheels.correct(self._fresh_points())
        elif self.still % LOOK_AGAIN == 0:
            self.look_again()

    def _displaced(self) -> None:
        self.displacements, self.still = self.displacements + 1, 0
        self.held_base.reset()

    def _fresh_points(self) -> FloatArray:
        """Return this period's points (n, 2) in the base frame, in [m]; none if the lidar repeats a scan."""
        assert self._range_sensor is not None
        scan = self._range_sensor.scan()
        return np.empty((0, 2)) if self._is_stale(scan) else self.crowd.without(scan.points(), self.pose)

    def _is_stale(self, scan: Scan) -> bool:
        if not np.array_equal(scan.ranges, self._ranges):
            self._ranges, self._seen_at = scan.ranges.copy(), self.travel
        return self.travel.away(self._seen_at) > STALE_SCAN_MOTION

    # Checkpoints

    def state(self) -> dict[str, Any]:
        """Return the estimates that a checkpoint needs, such as pose and covariance, as plain data."""
        state: dict[str, Any] = {
            name: attributes(part, kinds) for name, (part, kinds) in self._parts().items()
        }
        if self.local_map is not None:
            state[LOCAL_MAP_KEY] = self.local_map.echoes.ravel().tolist()
        if self.lifted is not None:
            state[LIFTED_KEY] = self.lifted.value
        return state

    def set_state(self, state: object) -> None:
        """Restore the estimates returned by `state`; raise `NotAState` for another kind of localization."""
        self.crowd = Crowd()
        parts, state = self._parts(), completed(state)
        if not isinstance(state, dict) or state.keys() - {LOCAL_MAP_KEY, LIFTED_KEY} != parts.keys():
            raise NotAState(f"no state of this localization; needed: {', '.join(parts)}")
        for name, (part, kinds) in parts.items():
            set_attributes(part, kinds, state[name])
        self._set_local_map(state.get(LOCAL_MAP_KEY))
        share = from_plain(state.get(LIFTED_KEY, 0.0), float, LIFTED_KEY)
        self.lifted, self.stale_s = lifted_by(share) if share else None, 0.0
        self.lift_watch.reset()
        self.held_base.reset()

    def _set_local_map(self, echoes: object) -> None:
        """Restore whether the pose on the map is known; `echoes` are those of the local map, if it is not."""
        if echoes is None:
            self.local_map = None
            self._wheels.surface_error = 0.0
            if self.map_field is not None:
                self._wheels.extend_map(self.map_field)
            return
        if not self.can_relocate:
            raise NotAState("no state of this localization: it needs a map and a lidar")
        self.local_map = local_map_of(from_plain(echoes, list[float], LOCAL_MAP_KEY), self.pose)
        self._wheels.extend_map(self.local_map.field)
        self._wheels.surface_error = DRAWN_SURFACE_M

    def _parts(self) -> dict[str, tuple[object, Kinds]]:
        """Return the parts that change in a run."""
        return {
            "localization": (self, self.STATE),
            "crowd": (self.crowd, self.crowd.STATE),
            "wheels": (self._wheels, self._wheels.STATE),
            "odometry": (self._wheels.odometry, self._wheels.odometry.STATE),
        }
