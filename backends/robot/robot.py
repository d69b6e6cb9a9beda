"""The robot as a primitive sees it: any backend, with what is estimated above it."""

from __future__ import annotations

from collections.abc import Callable, Generator
from functools import cached_property
from typing import Any, ClassVar, TypeVar, cast

import numpy as np

from handcart.backends.backend import Backend
from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.base import Base, DriveCommand, HolonomicBase
from handcart.backends.capabilities.camera import AnyCamera, Camera, CapabilityT, camera_of_kind
from handcart.backends.capabilities.capability import Capability
from handcart.backends.capabilities.gripper import Gripper
from handcart.backends.capabilities.imu import Imu
from handcart.backends.capabilities.missing_capability import MissingCapability
from handcart.backends.capabilities.range_sensor import RangeSensor
from handcart.backends.description.ground_spec import OUTDOOR_LOCALIZERS
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.plain_values import Kinds, attributes, set_attributes
from handcart.backends.robot.localization.lidar import Lidar, other_lidars
from handcart.backends.saved_state import NotAState
from handcart.backends.sensors.sensor_kind import capability_of
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import Transform
from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.kinematics.urdf_frames import base_T_frame
from handcart.robotics.navigation.following.drive_limits import DriveLimits
from handcart.robotics.navigation.following.way_guard import NO_STANDS, HoldingObstacle
from handcart.robotics.navigation.maps.grid_map import GridMap
from handcart.robotics.navigation.odometry.attitude import Attitude
from handcart.robotics.numerics.arrays import ByteArray, FloatArray

from .averaged_scan import AveragedScan
from .beside import beside
from .fresh_pictures import FreshPictures, Photo
from .guarded_base import GuardedBase, steady_points
from .localization.localizations import localization_of
from .progress_watch import ProgressWatch
from .robot_errors import MissingSensor, NoSidewaysDrive, UnknownStart
from .seen_people import SeenPeople
from .unseen_ground import UnseenGround

T = TypeVar("T")

LOW_HAND_HEIGHT_M = 0.6  # [m] of the hand above the ground: higher, and a scan goes below what it holds
HAND_RADIUS_M = 0.15  # [m] about the hand, in which a scan sees it and what it holds
BLIND_S = 0.3  # of one scan given again while the base moves, until it stops: at 5 Hz each is given for 0.2 s
MAX_STOP_PERIODS = 3  # control periods within which the command to stop leaves


class Robot:
    """Robot as primitives use it, with its backend, its file, and the estimates from its readings.

    Only the program's outermost loop calls `step`, once a period. `pose` is map_T_base, which this class
    estimates by the same code for all backends.
    """

    STATE: ClassVar[Kinds] = {"time": float, "failed_from": Pose2 | None}

    def __init__(
        self,
        backend: Backend,
        spec: RobotFile,
        start: Pose2 | None,
        grid: GridMap | None = None,
        is_start_exact: bool = False,
    ) -> None:
        """Connect a robot to its backend.

        Args:
            backend: backend that drives the robot.
            spec: the robot's file.
            start: map_T_base as the task states it, known to about 50 mm and 2 degrees; None if unknown.
            grid: map that scans are compared with; without it, or a lidar, the pose comes from the wheels.
            is_start_exact: whether the start defines the frame, because a map is missing.

        Raises:
            MissingCapability: the backend has no wheels.
            NoSidewaysDrive: the file has a holonomic drive, and the backend cannot drive sideways.
            UnknownStart: the start is unknown, and the robot cannot find its pose by scans.
        """
        self.backend, self.spec = backend, spec
        self.own_start = start if is_start_exact else None
        """2D pose in the map frame that the start has by definition if a map is missing; None with a map."""
        self.period, self.time = backend.period, 0.0
        self._known: dict[type[Capability], Capability] = {}
        sensor = backend.get(RangeSensor)  # type: ignore[type-abstract]
        self.lidar = None if sensor is None else Lidar(sensor, spec)
        """The robot's first lidar, with scans that are interpreted by the robot's file; None without one."""
        self.other_lidars = tuple(other_lidars(backend, spec, sensor))
        """Further lidars: the base keeps off what they see, too."""
        wheels = self.get(Base)  # type: ignore[type-abstract]
        if spec.drive.kind == "holonomic" and not isinstance(wheels, HolonomicBase):
            raise NoSidewaysDrive(backend)
        self._unseen = None if self.lidar is None else self._unseen_ground(self.lidar)
        self._averaged = AveragedScan(lambda: self.localization.odometry_pose, spec.footprint_shape.is_disc)
        self._guarded = GuardedBase(
            wheels,
            spec,
            grid,
            lambda: self.pose,
            self.surroundings,
            self._unseen,
            self._averaged.restart,
            lambda: self.localization.is_located,
            lambda: self.localization.stale_s > BLIND_S,
        )
        self.command = DriveCommand()
        """Command of the base in the last period."""
        self.held: HoldingObstacle | None = None
        """Obstacle for which the base was held back in the last period; None without one."""
        self.failed_from: Pose2 | None = None
        """map_T_base where the first of several Fails in a row began; None after any other outcome."""
        where = Pose2(0.0, 0.0, 0.0) if start is None else start
        self.localization = localization_of(backend, spec, where, grid, self.lidar, is_start_exact)
        """Estimate of the base's pose, from the sensors that the robot has."""
        self.progress = ProgressWatch(spec, self.period, self.localization)
        """Watch over the progress of the driven base."""
        if start is None:
            if not self.localization.can_relocate:
                raise UnknownStart(spec)
            self.localization.forget_pose()
        self._imu = backend.get(Imu)  # type: ignore[type-abstract]
        self._arm_command = np.empty(0)
        self._pictures = FreshPictures()
        self.people = SeenPeople()
        """People and carts that a drive tracks."""
        self._movers: set[int] = set()
        self._moved: set[int] = set()

    # Capabilities

    def get(self, kind: type[CapabilityT]) -> CapabilityT:
        """Return the first capability of the class `kind`, but a camera on the hand before any other camera.

        Raises:
            MissingCapability: the robot has no capability of that class.
        """
        if kind not in self._known:
            self._known[kind] = self._capability(kind)
        return self._known[kind]  # type: ignore[return-value]

    def _capability(self, kind: type[CapabilityT]) -> CapabilityT:
        if isinstance(self.lidar, kind):
            return self.lidar
        found = self.backend.get(kind)
        if isinstance(found, Camera):
            found = camera_of_kind(self.backend.capabilities(), kind)
        if found is None:
            raise MissingCapability(kind, self.backend.capabilities())
        return found

    def sensor(self, name: str) -> Capability:
        """Return a sensor by its name in the robot's file.

        Raises:
            MissingSensor: the robot's file has no such sensor, or the backend does not provide it.
        """
        lidars = (self.lidar, *self.other_lidars)
        read = (lidar for lidar in lidars if lidar is not None and lidar.sensor_name == name)
        found: Capability | None = next(read, None) or self.backend.sensor(name)
        if found is None and name in self.spec.sensors:
            kind = capability_of(self.spec.sensors[name].kind)
            alone = sum(capability_of(item.kind) is kind for item in self.spec.sensors.values()) == 1
            found = self.get(kind) if alone and self.backend.get(kind) is not None else None
        if found is None:
            raise MissingSensor(name, self.spec)
        return found

    def base_T_camera(self, camera: Camera) -> Transform:
        """Return the pose (4, 4) of a camera's optical frame (z forward, x right, y down) in the base frame,
        by the measured joints.
        """
        return self.base_T(camera.carrier) @ camera.carrier_T_camera

    @property
    def base(self) -> GuardedBase:
        """Base of the robot that refuses to drive into obstacles that the map or the scans show."""
        return self._guarded

    @property
    def arm(self) -> Arm:
        """Arm of the robot; raises `MissingCapability` without one."""
        return self.get(Arm)  # type: ignore[type-abstract]

    @property
    def gripper(self) -> Gripper:
        """Gripper of the robot; raises `MissingCapability` without one."""
        return self.get(Gripper)  # type: ignore[type-abstract]

    @property
    def camera(self) -> Camera:
        """Camera on the hand; raises `MissingCapability` without one."""
        return self.get(Camera)  # type: ignore[type-abstract]

    @property
    def view_camera(self) -> Camera:
        """Camera that watches the hand's work (the one on the hand, otherwise the first other camera)."""
        return cast("Camera", self.get(AnyCamera))

    @property
    def range_sensor(self) -> RangeSensor:
        """First lidar of the robot; its scans state each beam's validity (return, no return or invalid)."""
        return self.get(RangeSensor)  # type: ignore[type-abstract]

    @cached_property
    def arm_model(self) -> ArmModel:
        """Kinematic model of the arm from the URDF, up to the frame `hand`."""
        if self.spec.arm is None:
            raise MissingCapability(Arm, self.backend.capabilities())
        return self.spec.arm_model()

    @cached_property
    def joint_speeds(self) -> FloatArray:
        """Speed limits (n,) of the arm's joints by URDF and robot file, in [rad/s] or [m/s]."""
        return np.minimum(self.arm_model.velocity, self.spec.joint_speeds())

    @cached_property
    def drive_limits(self) -> DriveLimits:
        """Limits of the base's speed, turn rate and accelerations, in SI units."""
        return self.spec.drive.limits

    @property
    def stopping_distance(self) -> float:
        """Distance, in [m], that the base needs to stop from its top speed after a command to stop."""
        speed = self.drive_limits.speed
        return speed * MAX_STOP_PERIODS * self.period + speed**2 / (2.0 * self.drive_limits.acceleration)

    def _unseen_ground(self, lidar: Lidar) -> UnseenGround:
        radius = self.spec.footprint_radius_m
        return UnseenGround(lidar, radius, lambda: self.localization.odometry_pose, lambda: self.time)

    # Estimates

    @property
    def driven(self) -> tuple[float, float]:
        """Commanded speed ahead [m/s] and turn rate to the left [rad/s] of the last control period."""
        return self.command.speed, self.command.turn_rate

    @cached_property
    def attitude(self) -> Attitude:
        """Estimate of the base's turn and tilt by its IMU; without an IMU, always zero."""
        return Attitude()

    @property
    def pose(self) -> Pose2:
        """Estimated 2D pose map_T_base."""
        return self.localization.pose

    @cached_property
    def range_sensor_height(self) -> float:
        """Height of the lidar above the ground that the base is on, in [m]."""
        return float(base_T_frame(self.spec.urdf_text(), self.spec.lidar_link)[2, 3])

    def surroundings(self) -> FloatArray:
        """Return the points (n, 2) of obstacles in this period's scans, in the base frame, in [m]; empty
        without a lidar.

        Single readings that are too short (noise) are removed. Outdoors, points on the robot's own lowered
        hand are removed as well.
        """
        if self.lidar is None:
            return NO_STANDS
        points = steady_points(self._averaged.take(self.lidar.scan()))
        if self.other_lidars:
            points = np.vstack([points, *(steady_points(lidar.scan()) for lidar in self.other_lidars)])
        return self.without_hand(points) if self.spec.localizer in OUTDOOR_LOCALIZERS else points

    def without_hand(self, points: FloatArray) -> FloatArray:
        """Return the `points` (n, 2) that are not on a lowered hand, (m, 2) in the base frame, in [m]."""
        if self.spec.arm is None or self.backend.get(Arm) is None:  # type: ignore[type-abstract]
            return points
        hand = self.base_T("hand")[:3, 3]
        if hand[2] >= LOW_HAND_HEIGHT_M:
            return points
        return np.asarray(points[np.hypot(*(points - hand[:2]).T) > HAND_RADIUS_M])

    def base_T(self, frame: str) -> Transform:
        """Return the pose (4, 4) of a frame of the robot in the base frame, by the measured joints."""
        if self.spec.arm is None:
            return base_T_frame(self.spec.urdf_text(), frame)
        return self.arm_model.forward(self.arm.joints(), frame)

    # Time

    def step(self, paused: bool = False) -> None:
        """Execute one control period and update the estimates; `time` advances unless `paused` is True."""
        self._moved, self._movers = self._movers, set()
        self.command, self.held = self._guarded.taken()
        self.backend.step()
        self.time += 0.0 if paused else self.period
        self._feel()
        self._locate()
        if self._pictures.awaits_motion:
            self._pictures.note(self._carried_by())

    def _locate(self) -> None:
        """Update the estimated pose, and detect whether the base is blocked."""
        travel, before = self.localization.travel, self.localization.odometry_pose
        self.localization.update(self.command)
        self.progress.update(self.command, travel, before)
        if self.progress.blocked is not None or self.progress.blocked_wheel is not None:
            self.localization.lift_watch.note_contact()

    def _feel(self) -> None:
        """Update the attitude with the readings of the inertial sensors."""
        if self._imu is None:
            return
        arm = self.backend.get(Arm)  # type: ignore[type-abstract]
        command = arm.command() if arm else np.empty(0)
        before, self._arm_command = self._arm_command, command
        at_rest = len(command) == len(before) and bool((command == before).all())
        at_rest = at_rest and self.localization.still > 0
        self.attitude.update(self._imu.rates(), self._imu.accelerations(), self.period, at_rest)

    def picture(self) -> ByteArray:
        """Return the picture (height, width) of `view_camera`, grey, 0 to 255.

        Raises:
            StaleReading: all pixels equal those of the previous picture, although arm or wheels have moved. A
                camera without noise may return the same picture if the robot is back at the same pose.
        """
        noisy = self.spec.errors.image_noise_grey > 0.0
        return self._pictures.take(self.view_camera.image(), self._carried_by(), noisy)

    def photo(self) -> Photo:
        """Return picture, pose and time of `view_camera`; raise `StaleReading` for a repeated picture."""
        camera = self.view_camera
        return Photo(self.picture(), camera.model, self.base_T_camera(camera), self.time)

    def _carried_by(self) -> FloatArray:
        """Return the positions (3 + n,) that carry the camera: travel of the wheels (left, right, sideways)
        in [m], then the commanded joints in [rad] or [m].
        """
        arm = self.backend.get(Arm)  # type: ignore[type-abstract]
        return np.concatenate([self.localization.travel, arm.command() if arm else np.empty(0)])

    @property
    def seen(self) -> ByteArray | None:
        """Picture (height, width) that the robot took last, grey, 0 to 255; None before the first."""
        return self._pictures.last

    def state(self) -> dict[str, Any]:
        """Return the estimates that a checkpoint needs, such as pose and localization, as plain data."""
        state = {
            "robot": attributes(self, self.STATE),
            "attitude": attributes(self.attitude, self.attitude.STATE),
            "localization": self.localization.state(),
        }
        if self._unseen is not None and self._unseen.is_partial:
            state["driven"] = attributes(self._unseen, self._unseen.STATE)
        return state

    def set_state(self, state: object) -> None:
        """Restore the estimates returned by `state`, after the backend's state was restored.

        Raises:
            NotAState: the data are not the estimates of a robot with the same kind of localization.
        """
        if not isinstance(state, dict) or state.keys() - {"driven"} != {"robot", "attitude", "localization"}:
            raise NotAState("no state of this robot; needed: robot, attitude, localization")
        set_attributes(self, self.STATE, state["robot"])
        set_attributes(self.attitude, self.attitude.STATE, state["attitude"])
        self.localization.set_state(state["localization"])
        if self._unseen is not None and "driven" in state:
            set_attributes(self._unseen, self._unseen.STATE, state["driven"])

    def moved_by(self, who: object) -> bool:
        """Note that `who` moves the robot; False if two or more objects did so in this or the last period."""
        self._movers.add(id(who))
        return len(self._movers) == 1 and len(self._moved) <= 1

    def stop(self) -> None:
        """Stop all motion of base, arm and gripper."""
        self._guarded.taken()
        self.backend.stop()

    def compute(self, work: Callable[..., T], *args: object, takes: float = 0.2) -> Generator[None, None, T]:
        """Run a long computation while the robot holds still and its time passes.

        Args:
            work: function to run.
            args: its positional arguments.
            takes: simulated duration of the computation, in [s]; on a real robot the function runs in a
                thread and takes as long as it needs.
        """
        if not self.backend.simulated:
            return (yield from beside(work, *args))
        result = work(*args)
        yield from self.wait(takes)
        return result

    def wait(self, seconds: float) -> Generator[None, None, None]:
        """Hold still for a time, in [s] of the robot's time."""
        end = self.time + seconds
        while self.time < end - 1e-9:
            yield
