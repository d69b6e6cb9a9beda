"""The robot as a primitive sees it: any backend, with what is estimated above it."""

from __future__ import annotations

import math
from collections.abc import Callable, Generator
from functools import cached_property
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from handcart.backends.backend import Backend
from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.base import Base, WheelTravel
from handcart.backends.capabilities.camera import Camera
from handcart.backends.capabilities.capability import Capability
from handcart.backends.capabilities.gps import Gps
from handcart.backends.capabilities.gripper import Gripper
from handcart.backends.capabilities.imu import Imu
from handcart.backends.capabilities.positioning import Positioning
from handcart.backends.capabilities.range_sensor import RangeSensor
from handcart.backends.description.ground_spec import OUTDOORS
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.plain_values import Kinds, attributes, set_attributes
from handcart.backends.saved_state import NotAState
from handcart.files.errors import HandcartError
from handcart.robotics.far import FarArray
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import Transform
from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.navigation.following.drive_limits import DriveLimits
from handcart.robotics.navigation.following.way_guard import NOTHING, Held
from handcart.robotics.navigation.localization.attitude import Attitude
from handcart.robotics.navigation.localization.localizer import Localizer, OdometryLocalizer, ScanLocalizer
from handcart.robotics.navigation.localization.positioning_localizer import PositioningLocalizer
from handcart.robotics.navigation.localization.scan_matching import LikelihoodField
from handcart.robotics.navigation.maps.grid_map import GridMap
from handcart.robotics.navigation.outdoors.field_localizer import FieldLocalizer
from handcart.robotics.navigation.outdoors.gps_filter import GpsFilter

from .beside import beside
from .field_belief import field_localizer
from .guarded_base import GuardedBase, steady_points
from .noted_base import NotedBase

T = TypeVar("T")
C = TypeVar("C", bound=Capability)

STILL_SCANS = 20  # periods at rest after which further scans tell nothing new
LOWERED = 0.6  # [m] of the hand above the ground: higher, and a scan goes below what it holds
HAND = 0.15  # [m] about the hand, in which a scan sees it and what it holds
LOOK_AGAIN = 10  # periods at rest between scans that tell whether somebody moved the base
STALE = 1e-3  # [m], [rad] of motion in which scan or picture can't stay the same to the last bit
SCAN_SIGMA = (0.004, 0.0015)  # [m], [rad]: spread of scan matches about one place
_STATE = {
    "time": float,
    "pushes": int,
    "_travel": WheelTravel,
    "_still": int,
    "_ranges": FarArray,
    "_seen_at": WheelTravel,
}
"""What a checkpoint keeps, with the types."""
START_SIGMA = np.diag([0.05**2, 0.05**2, 0.035**2])  # [m², rad²] of where a task says the robot starts


class MissingCapability(HandcartError, ValueError):
    """The robot can't do what is asked of it."""

    exit_status = 2

    def __init__(self, kind: type[Capability], robot: Backend) -> None:
        have = ", ".join(sorted(_name(type(each)) for each in robot.capabilities()))
        super().__init__(f"the robot has no {kind.__name__}; it has: {have}")


class StaleReading(HandcartError, RuntimeError):
    """A sensor gives an old reading for a new one."""


def _name(kind: type) -> str:
    return next(each.__name__ for each in kind.__mro__ if Capability in each.__bases__)


class Robot:
    """A backend, its file, and the estimates that follow from its readings.

    The outermost loop calls `step` once a period; primitives never do. `pose` is map_T_base, estimated once
    above all backends, so the same for all of them.
    """

    def __init__(self, backend: Backend, spec: RobotFile, start: Pose2, grid: GridMap | None = None) -> None:
        """Take a backend over.

        Args:
            backend: behind it.
            spec: the robot's file.
            start: map_T_base as the task states it, known to about 50 mm and 2 degrees.
            grid: what scans are compared with; without it, or a range sensor, wheels alone tell the pose.
        """
        self.backend = backend
        self.spec = spec
        self.period = backend.period
        self.time = 0.0
        self._wheels = NotedBase(self.get(Base))  # type: ignore[type-abstract]
        self._guarded = GuardedBase(self._wheels, spec, grid, lambda: self.pose, self.surroundings)
        self.driven = (0.0, 0.0)
        """Speed in [m/s] and turn rate in [rad/s] that the base was commanded in the last period."""
        self.held: Held | None = None
        """What the base was held back from in the last period: it would have touched that."""
        self._localizer = self._make_localizer(start, grid)
        self.outdoors: FieldLocalizer | None = self._make_outdoors(start)
        """What wheels, gyros and satellites say together, where the robot's file names one that asks them."""
        self.pushes = 0
        """How often the base was found elsewhere than it stood."""
        self._travel = self.base.wheel_travel()
        self._still = 0
        self.attitude = Attitude()
        """Turn and tilt by the inertial sensors; without them it stays as it is."""
        self._imu = backend.get(Imu)  # type: ignore[type-abstract]
        self._arm_told = np.empty(0)
        self._ranges, self._seen_at = np.empty(0), self._travel
        self._picture, self._pictured_at = np.empty((0, 0), np.uint8), np.empty(0)
        self._movers: set[int] = set()
        self._moved: set[int] = set()

    def _make_localizer(self, start: Pose2, grid: GridMap | None) -> Localizer:
        tread = self.spec.drive.tread_m
        told = self.spec.positioning
        if self.spec.localiser == "positioning" and told and self.backend.get(Positioning):  # type: ignore[type-abstract]
            sigma = told.sigma_mm / 1e3, told.heading_sigma_mrad / 1e3
            return PositioningLocalizer(start, tread, sigma, covariance=START_SIGMA)
        if self.spec.localiser == "odometry" or grid is None or self.backend.get(RangeSensor) is None:  # type: ignore[type-abstract]
            seen = grid is not None and self.backend.get(RangeSensor) is not None  # type: ignore[type-abstract]
            field = LikelihoodField(grid) if grid is not None and seen else None
            return OdometryLocalizer(start, tread, covariance=START_SIGMA, field=field)
        localizer = ScanLocalizer(LikelihoodField(grid), start, tread, covariance=START_SIGMA)
        localizer.correct(self.range_sensor.scan().points())
        return localizer

    def _make_outdoors(self, start: Pose2) -> FieldLocalizer | None:
        if self.spec.localiser not in OUTDOORS:
            return None
        self.get(Imu)  # type: ignore[type-abstract]
        return field_localizer(self.spec, start, self.spec.antenna)

    # What it can do

    def get(self, kind: type[C]) -> C:
        """A capability; raises `MissingCapability` where the robot has none of that kind."""
        found = self.backend.get(kind)
        if found is None:
            raise MissingCapability(kind, self.backend)
        return found

    @property
    def base(self) -> GuardedBase:
        """The wheels; they don't drive into what map or scan shows."""
        return self._guarded

    @property
    def arm(self) -> Arm:
        """The arm."""
        return self.get(Arm)  # type: ignore[type-abstract]

    @property
    def gripper(self) -> Gripper:
        """The gripper."""
        return self.get(Gripper)  # type: ignore[type-abstract]

    @property
    def camera(self) -> Camera:
        """The camera on the hand."""
        return self.get(Camera)  # type: ignore[type-abstract]

    @property
    def range_sensor(self) -> RangeSensor:
        """The range sensor."""
        return self.get(RangeSensor)  # type: ignore[type-abstract]

    @cached_property
    def arm_model(self) -> ArmModel:
        """Kinematics of the arm, from the URDF; its tip is the frame `hand`."""
        if self.spec.arm is None:
            raise MissingCapability(Arm, self.backend)
        return self.spec.arm_model()

    @cached_property
    def drive_limits(self) -> DriveLimits:
        """Of the base."""
        drive = self.spec.drive
        return DriveLimits(
            drive.top_speed_m_s,
            np.radians(drive.top_turn_deg_s),
            drive.acceleration_m_s2,
            np.radians(drive.turn_acceleration_deg_s2),
        )

    # What is estimated

    @property
    def pose(self) -> Pose2:
        """map_T_base."""
        return self._localizer.pose if self.outdoors is None else self.outdoors.pose

    @property
    def reckoned(self) -> Pose2:
        """The base by what doesn't jump: outdoors wheels and gyros, in a frame of their own; else `pose`."""
        return self._localizer.pose if self.outdoors is None else self.outdoors.odometry.pose

    @property
    def tilt(self) -> tuple[float, float]:
        """Roll and pitch of the base in [rad]; zero where nothing tells."""
        return (0.0, 0.0) if self.outdoors is None else self.outdoors.tilt

    @property
    def pose_covariance(self) -> NDArray[np.float64]:
        """(3, 3) of x, y in [m] and heading in [rad]."""
        return self._localizer.covariance if self.outdoors is None else self.outdoors.covariance

    @property
    def pose_sigma(self) -> tuple[float, float]:
        """How well two poses that are both measured like this one can be compared: one sigma, [m] and [rad].

        Where scans are matched with the map, the map's own error is the same in both; by wheels alone it is
        all that has been added up since the surroundings were last seen. A lost robot knows nothing.
        """
        if self.lost:
            return math.inf, math.inf
        if self.outdoors is None and isinstance(self._localizer, ScanLocalizer) and self._localizer.sure:
            return SCAN_SIGMA
        sigma = np.sqrt(np.diag(self.pose_covariance))
        return float(np.hypot(sigma[0], sigma[1])), float(sigma[2])

    @property
    def lost(self) -> bool:
        """Whether the scans no longer fit the map anywhere near."""
        return isinstance(self._localizer, ScanLocalizer) and self._localizer.lost

    @property
    def explained(self) -> float:
        """Share of the last scan's points that the map explains; NaN where no scan is compared with it."""
        match = self._localizer.last_match if isinstance(self._localizer, ScanLocalizer) else None
        return match.inliers if match is not None else np.nan

    def surroundings(self) -> NDArray[np.float64]:
        """(n, 2) in [m], in the base frame: what this period's scan shows without lone readings and a lowered
        hand's own; nothing without a range sensor."""
        sensor = self.backend.get(RangeSensor)  # type: ignore[type-abstract]
        if sensor is None:
            return NOTHING
        points = steady_points(sensor.scan())
        return self.without_hand(points) if self.outdoors is not None else points

    def without_hand(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Those of the points (n, 2), in [m], in the base frame, that aren't a lowered hand's own."""
        if self.spec.arm is None or self.backend.get(Arm) is None:  # type: ignore[type-abstract]
            return points
        hand = self.base_T("hand")[:3, 3]
        if hand[2] >= LOWERED:
            return points
        return np.asarray(points[np.hypot(*(points - hand[:2]).T) > HAND])

    def base_T(self, frame: str) -> Transform:
        """Pose of a frame of the arm in the base frame by the measured joints, (4, 4)."""
        return self.arm_model.forward(self.arm.joints(), frame)

    # Time

    def step(self, paused: bool = False) -> None:
        """Let one period pass and bring the estimates up to date; in a pause `time` stands still."""
        self._moved, self._movers = self._movers, set()
        self.driven, self.held = self._wheels.taken(), self._guarded.taken_held()
        self.backend.step()
        self.time += 0.0 if paused else self.period
        travel = self.base.wheel_travel()
        if not np.isfinite(travel).all():
            travel = self._travel  # the next sound reading has it all
        left, right = travel.left - self._travel.left, travel.right - self._travel.right
        self._travel = travel
        self._localizer.predict(left, right)
        self._feel()
        self._locate(left, right)
        if left == right == 0.0:
            self._still += 1
        else:
            self.look_again()  # a roll must not hide that the base no longer stood where it stood
            self._still = 0
        if isinstance(self._localizer, PositioningLocalizer):
            self._take_reading(self._localizer)
            return
        if self.outdoors is not None or self.backend.get(RangeSensor) is None:  # type: ignore[type-abstract]
            return
        if self._still <= STILL_SCANS:
            self._localizer.correct(self._fresh_points())
        elif self._still % LOOK_AGAIN == 0:
            self.look_again()

    def _take_reading(self, localizer: PositioningLocalizer) -> None:
        """Take in what the positioning system tells; a base that it finds elsewhere at rest was pushed."""
        reading = self.get(Positioning).reading()  # type: ignore[type-abstract]
        if reading is None or not np.isfinite((*reading.pose, reading.age)).all():
            return  # a broken one is no reading
        periods = round(reading.age / self.period)
        if localizer.take(reading.number, reading.pose, periods) and self._still > periods:
            self.pushes += 1
            self._still = 0

    def _feel(self) -> None:
        """Take in what the inertial sensors read."""
        if self._imu is None:
            return
        arm = self.backend.get(Arm)  # type: ignore[type-abstract]
        told = arm.command() if arm else np.empty(0)
        at_rest = self._still > 0 and np.array_equal(told, self._arm_told)
        self._arm_told = told
        self.attitude.update(self._imu.rates(), self._imu.accelerations(), self.period, at_rest)

    def _locate(self, left: float, right: float) -> None:
        """Outdoors: take in what wheels, gyros and receiver read."""
        if self.outdoors is None or self._imu is None:
            return
        rolled = np.array([left, right])
        self.outdoors.predict(self._imu.rates(), self._imu.accelerations(), rolled, self.period)
        gps = self.backend.get(Gps)  # type: ignore[type-abstract]
        fix = gps.fix() if gps else None
        if fix is not None:
            self.outdoors.fix(fix.position)

    def look_again(self) -> None:
        """At rest, see whether the base still stands where it stood; if not, find where."""
        if self._still <= STILL_SCANS or self.backend.get(RangeSensor) is None:  # type: ignore[type-abstract]
            return
        if self._localizer.find_again(self._fresh_points()):
            self.pushes += 1
            self._still = 0

    def _fresh_points(self) -> NDArray[np.float64]:
        """(n, 2) in [m] of this period's scan; none if it is stale: the same although the wheels rolled."""
        scan = self.range_sensor.scan()
        if not np.array_equal(scan.ranges, self._ranges):
            self._ranges, self._seen_at = scan.ranges.copy(), self._travel
        rolled = np.abs(np.subtract(self._travel, self._seen_at)).max()
        return np.empty((0, 2)) if rolled > STALE else scan.points()

    def found_at(self, pose: Pose2, sigma: tuple[float, float]) -> None:
        """The base was measured to stand at map_T_base, with that sigma in [m] and in [rad]."""
        variance = np.diag([sigma[0], sigma[0], sigma[1]]) ** 2
        self._localizer.odometry.correct(pose, variance)

    def note_place(self) -> None:
        """Outdoors: this moment is wanted when it is told, after the run, where the robot was."""
        if isinstance(self.outdoors, GpsFilter):
            self.outdoors.mark()

    @property
    def dead_reckoned(self) -> bool:
        """Whether nothing but the wheels tells how the base moves."""
        if self.outdoors is not None:
            return self.spec.localiser == "gyro" or self.backend.get(Gps) is None  # type: ignore[type-abstract]
        return isinstance(self._localizer, OdometryLocalizer)

    def picture(self) -> NDArray[np.uint8]:
        """The camera's picture, (height, width) grey.

        Raises:
            StaleReading: it is the last one to the last bit, although arm or wheels have moved since.
        """
        arm = self.backend.get(Arm)  # type: ignore[type-abstract]
        here = np.concatenate([self._travel, arm.command() if arm else np.empty(0)])
        image = self.camera.image()
        if np.array_equal(image, self._picture) and np.abs(here - self._pictured_at).max() > STALE:
            raise StaleReading("the camera gives its last picture again, although it has moved")
        self._picture, self._pictured_at = image, here
        return image

    def state(self) -> dict[str, Any]:
        """What was estimated so far, for a checkpoint, as plain data."""
        return {name: attributes(part, kinds) for name, (part, kinds) in self._parts().items()}

    def set_state(self, state: object) -> None:
        """Take over what `state` gave, on a backend that stands as it did then.

        Raises:
            NotAState: it is of something else.
        """
        parts = self._parts()
        if not isinstance(state, dict) or state.keys() != parts.keys():
            raise NotAState(f"no state of this robot; needed: {', '.join(parts)}")
        for name, (part, kinds) in parts.items():
            set_attributes(part, kinds, state[name])

    def _parts(self) -> dict[str, tuple[object, Kinds]]:
        """What changes in a run."""
        parts: dict[str, tuple[object, Kinds]] = {
            "robot": (self, _STATE),
            "localizer": (self._localizer, self._localizer.STATE),
            "odometry": (self._localizer.odometry, self._localizer.odometry.STATE),
            "attitude": (self.attitude, self.attitude.STATE),
        }
        if self.outdoors is not None:
            parts["outdoors"] = (self.outdoors, self.outdoors.STATE)
            parts["reckoned"] = (self.outdoors.odometry, self.outdoors.odometry.STATE)
        return parts

    def moved_by(self, who: object) -> bool:
        """Note who moves the robot in this period; whether nobody else does, nor did in the last one."""
        self._movers.add(id(who))
        return len(self._movers) == 1 and len(self._moved) <= 1

    def stop(self) -> None:
        """Stop all motion."""
        self._wheels.taken()
        self._guarded.taken_held()
        self.backend.stop()

    def compute(self, work: Callable[..., T], *args: object, takes: float = 0.2) -> Generator[None, None, T]:
        """Long computing: the robot holds meanwhile, and its time passes.

        In simulation that takes `takes` in [s]; a real robot has it done beside the control loop.
        """
        if not self.backend.simulated:
            return (yield from beside(work, *args))
        result = work(*args)
        yield from self.wait(takes)
        return result

    def wait(self, seconds: float) -> Generator[None, None, None]:
        """Hold for that long, in [s] of the robot's time."""
        end = self.time + seconds
        while self.time < end - 1e-9:
            yield
