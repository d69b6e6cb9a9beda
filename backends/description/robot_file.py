"""A robot's file: the content of `robot.yaml`, next to its URDF."""

from __future__ import annotations

import math
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import numpy as np
from pydantic import Field, PrivateAttr

from handcart.backends.urdf.robot_parts import KeyPath, PartSpec, UrdfPlace
from handcart.backends.urdf.robot_urdf import RobotUrdf, robot_urdf
from handcart.files.errors import InputError
from handcart.files.models.model import FileModel
from handcart.robotics.kinematics.urdf_contents import joints_of, link_names
from handcart.robotics.kinematics.urdf_frames import base_T_frame
from handcart.robotics.kinematics.urdf_mounts import joints_between
from handcart.robotics.manipulation.suspension.suspension_model import SuspensionModel
from handcart.robotics.numerics.arrays import FloatArray

from .can_spec import CanSpec
from .drive_spec import ALL_DRIVE_KINDS as ALL_DRIVE_KINDS
from .drive_spec import Drive as Drive
from .footprint_spec import OutlinedFile
from .ground_spec import GroundSpec
from .joint_units import JointUnits
from .ros_spec import RosSpec
from .sensor_specs import CameraSpec, OdometrySpec
from .sensor_table import SensorTable
from .simulated_errors import Errors

if TYPE_CHECKING:
    from handcart.backends.urdf.robot_shape import FingerShape, TrayShape
    from handcart.robotics.kinematics.arm_model import ArmModel

    from .sensor_spec import SensorSpec

Positive = Annotated[float, Field(gt=0.0)]
Role = Literal["base", "hand", "tray", "range_sensor", "camera", "imu", "gps"]
NotNegative = Annotated[float, Field(ge=0.0)]


class ArmSpec(FileModel):
    """Joints, limits, accuracy and named postures of an arm, as a robot's file states them."""

    joints: tuple[str, ...]
    """Names of the arm's joints in the URDF, from the shoulder to the hand."""
    top_speed_deg_s: Positive
    acceleration_deg_s2: Positive
    slide_speed_mm_s: Positive | None = None
    """Maximum speed of sliding joints, such as a lift; required if one exists."""
    slide_acceleration_mm_s2: Positive | None = None
    accuracy_mm: Positive = 0.5
    """Sigma of the hand's position against its joints, along each axis."""
    working_deg: dict[str, tuple[float, float]] = Field(default_factory=dict)
    """Narrower limits (lowest, highest) of turning joints, by name, for working poses of the hand; motions
    between them use the URDF's limits.
    """
    postures: dict[str, tuple[float, ...]]
    """Joint angles in [deg], of joints that slide [mm], in the order of `joints`. `handcart teach` adds to
    them."""


class GripperSpec(FileModel):
    """Opening, speed and force of a gripper with two fingers, as a robot's file states them."""

    opening_mm: Positive
    speed_mm_s: Positive
    force_n: Positive
    grasp: Literal["friction", "constraint"] = "friction"
    """Grasp in a physics engine: the pads' friction, or a rigid link created when both fingers press."""
    left: str | None = None
    """The joint of the left finger, where the URDF doesn't call it `left_finger`."""
    right: str | None = None
    """Joint of the right finger."""


class ToolSpec(FileModel):
    """A tool in the hand, such as a torch; it points along the x axis of the URDF's frame `hand`."""

    free: Literal["nothing", "azimuth", "roll"] = "roll"
    """The turn that the work leaves free: about the vertical (arms without wrist yaw), or about the tool."""
    azimuth_tolerance_deg: Annotated[float, Field(gt=0.0, le=180.0)] = 60.0
    """Allowed turn of the tool with `azimuth`."""
    speed_m_s: Positive
    """Speed of the tool along its path at work."""
    force_n: Positive
    """Largest force with which the tool is pushed along the path."""


class SuspensionSpec(FileModel):
    """Tilt and turn of the base under the arm's load, as measured by `tasks/calibrate_suspension`.

    The robot's estimated poses are corrected by these values; a simulated base does not tilt by them.
    """

    yaw_mrad_per_swing: float = 0.0
    """Turn of the base to the left with each swing, which is a motion of the loaded arm by at least
    `swing_from_mm`.
    """
    yaw_sigma_mrad: NotNegative = 0.0
    """Sigma of the turn with each swing."""
    swing_from_mm: NotNegative = 0.0
    """Minimum distance by which the hand carries a load in a motion that counts as a swing."""
    roll_mrad_per_m: float = 0.0
    """Roll of the base for each metre of the hand to the left; negative if that side sinks."""
    pitch_mrad_per_m: float = 0.0
    """Pitch of the base for each metre of the hand to the front; positive if the front sinks."""
    pivot_m: NotNegative = 0.0
    """Height of the point about which the base tilts."""

    @property
    def model(self) -> SuspensionModel:
        """Model of the base's tilt and turn under the arm's load, in SI units."""
        return SuspensionModel(
            self.yaw_mrad_per_swing / 1e3,
            self.roll_mrad_per_m / 1e3,
            self.pitch_mrad_per_m / 1e3,
            self.pivot_m,
        )


class Tolerance(FileModel):
    """Largest differences up to which a measured state of robot and objects counts as equal to the expected
    one.
    """

    base_mm: Positive
    base_deg: Positive
    joints_deg: Positive
    slides_mm: Positive = 2.0
    """Tolerance of the arm's sliding joints."""
    gripper_mm: Positive
    object_mm: Positive


class UnknownPosture(InputError):
    """Error: the robot's file does not have the requested posture."""


class RobotFile(SensorTable, OutlinedFile):
    """Content of a robot's YAML file, with drive, arm, sensors, limits, tolerances, postures and simulated
    errors.
    """

    format: Literal["handcart-robot/1"]
    urdf: UrdfPlace
    srdf: UrdfPlace | None = None
    """MoveIt's SRDF file of the robot's own URDF: which links may touch each other (`disable_collisions`)."""
    without: tuple[str, ...] = ()
    """Joints of `urdf` that are removed with all links behind them."""
    still: dict[str, float] = Field(default_factory=dict)
    """Joints that are never moved, such as those of a second arm, with their positions in [deg], or [mm] if
    they slide.
    """
    links: dict[Role, str] = Field(default_factory=dict)
    """Links of the URDF by their expected names: `hand: tool0`."""
    allowed_contacts: tuple[tuple[str, str], ...] = ()
    """Pairs of links that may touch, such as those of a concave mesh's hull; `handcart check --allow`
    proposes them.
    """
    parts: tuple[PartSpec, ...] = ()
    """Further URDFs, unchanged, each fixed onto a link of an earlier one."""
    period_s: Positive
    """The control period."""
    localizer: Literal["scan", "odometry", "positioning", "gyro", "particle", "gps_filter", "beacons"]
    """Estimator of the pose: ranges against the map; wheels, and ranges at rest; outdoors wheels and gyros,
    the particle filter of Ohki et al. (2012), or a Kalman filter that models the errors of all three; or a
    filter of wheels, gyros and ranges to radio beacons.
    """
    drive: Drive
    can: CanSpec | None = None
    """Connection of the backend `can` to the robot's drives."""
    ros2: RosSpec | None = None
    """Topics of the backend `ros2`."""
    arm: ArmSpec | None = None
    gripper: GripperSpec | None = None
    ground: GroundSpec = GroundSpec()
    """Assumed properties of open ground."""
    odometry: OdometrySpec = OdometrySpec()
    """Assumed accuracy of the wheel odometry on a floor."""
    tool: ToolSpec | None = None
    suspension: SuspensionSpec = SuspensionSpec()
    """Known tilt and turn of the base under the arm's load."""
    tray_grey: Annotated[int, Field(ge=0, le=255)] = 205
    """Grey value of the tray in a camera's picture."""
    errors: Errors = Errors()
    tolerance: Tolerance
    _folder: Path = PrivateAttr(default=Path())
    _warnings: tuple[str, ...] = PrivateAttr(default=())
    _whole: RobotUrdf | None = PrivateAttr(default=None)

    @property
    def folder(self) -> Path:
        """Folder of the robot's file; paths in the file are relative to it."""
        return self._folder

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings on keys of the file that are still read but should be written differently."""
        return self._warnings

    def read_in(self, folder: Path, warnings: tuple[str, ...] = ()) -> RobotFile:
        """Store the folder of the robot's file and the warnings from reading it; return the same object."""
        self._folder, self._warnings = folder, warnings
        return self

    @property
    def whole(self) -> RobotUrdf:
        """Complete robot, assembled from its URDFs; raises `UrdfError` if they do not fit together."""
        if self._whole is None:
            own = PartSpec(urdf=self.urdf, srdf=self.srdf, without=self.without, onto="")
            named, allowed = self.mapped_joints(), self.allowed_contacts
            self._whole = robot_urdf((own, *self.parts), self._folder, self.links, named, allowed, self.still)
        return self._whole

    def urdf_text(self) -> str:
        """Return the URDF of the complete robot, assembled from its parts; meshes are named by absolute
        paths.

        Raises:
            UrdfError: a part is missing, or cannot be fixed onto the link that the robot's file names.
        """
        return self.whole.text

    def mapped_joints(self) -> list[tuple[KeyPath, str, str]]:
        """Return the joints of wheels and fingers that the robot's file renames.

        Returns:
            For each joint its key path in the file, its name in the URDF, and the name that programs use.
        """
        found: list[tuple[KeyPath, str, str]] = []
        for side in ("left", "right"):
            wheels = getattr(self.drive, side)
            several = isinstance(wheels, tuple) and len(wheels) > 1
            for number, joint in enumerate([wheels] if isinstance(wheels, str) else wheels or (), start=1):
                name = f"{side}_{number}_wheel" if several else f"{side}_wheel"
                found.append((("drive", side), joint, name))
            finger = None if self.gripper is None else getattr(self.gripper, side)
            if finger is not None:
                found.append((("gripper", side), finger, f"{side}_finger"))
        return found

    def arm_model(self) -> ArmModel:
        """Return a new kinematic model of the arm; raise ValueError if the robot has no arm."""
        from handcart.robotics.kinematics.arm_model import ArmModel

        if self.arm is None:
            raise ValueError("the robot has no arm")
        model = ArmModel(self.urdf_text(), self.arm.joints, allowed=self.whole.allowed)
        model.velocity = np.where(model.velocity > 0.0, model.velocity, self.joint_speeds())
        return model

    @cached_property
    def described_arm(self) -> ArmModel:
        """Kinematic model of the arm, shared by all callers, for reading shapes and limits only.

        Code that sets joint values in a model has to create a model of its own by `arm_model`. Raises
        ValueError without an arm.
        """
        return self.arm_model()

    @cached_property
    def joint_units(self) -> JointUnits:
        """Units of the arm's joints in files and messages, [deg] or [mm]; empty if the robot has no arm."""
        names = () if self.arm is None else self.arm.joints
        kinds = {item.name: item.kind for item in joints_of(self.urdf_text())} if names else {}
        of_arm = [kinds.get(name) for name in names]
        slides = tuple(kind == "prismatic" for kind in of_arm)
        return JointUnits(names, slides, tuple(kind == "continuous" for kind in of_arm))

    def joint_speeds(self) -> FloatArray:
        """Speed limits (n,) of the arm's joints by the robot's file, in [rad/s] or [m/s]; empty without an
        arm.
        """
        arm = self.arm
        return np.empty(0) if arm is None else self._each(arm.top_speed_deg_s, arm.slide_speed_mm_s)

    def joint_accelerations(self) -> FloatArray:
        """Acceleration limits (n,) of the arm's joints by the robot's file, in [rad/s²] or [m/s²]; empty
        without an arm.
        """
        arm = self.arm
        return (
            np.empty(0) if arm is None else self._each(arm.acceleration_deg_s2, arm.slide_acceleration_mm_s2)
        )

    def _each(self, turning_deg: float, sliding_mm: float | None) -> FloatArray:
        turns, slides = math.radians(turning_deg), (sliding_mm or 0.0) / 1e3
        return np.array([slides if slide else turns for slide in self.joint_units.slides])

    @cached_property
    def has_tray(self) -> bool:
        """True if the robot has an arm, and its URDF has a link `tray` on which it carries things."""
        return self.arm is not None and "tray" in link_names(self.urdf_text())

    @cached_property
    def antenna(self) -> tuple[float, float, float]:
        """Position of the GNSS antenna in the base frame, in [m]; (0, 0, 0) without a receiver."""
        if self.gps is None:
            return (0.0, 0.0, 0.0)
        x, y, z = base_T_frame(self.urdf_text(), self.link_of(self.gps))[:3, 3].tolist()
        return (x, y, z)

    def link_of(self, sensor: SensorSpec) -> str:
        """Return the name of the URDF's link on which a sensor of the robot is mounted; "" for a sensor
        without a link.

        A link to which the key `links` of the robot's file gives a role, such as `hand`, is named by that
        role.
        """
        wanted = sensor.link(self.name_of(sensor))
        return next((role for role, link in self.links.items() if link == wanted), wanted)

    @property
    def lidar_link(self) -> str:
        """Link of the robot's first lidar; `range_sensor` if the robot has no lidar."""
        return "range_sensor" if self.range_sensor is None else self.link_of(self.range_sensor)

    @property
    def hand_camera(self) -> CameraSpec | None:
        """Description of the first camera that is fixed on the hand; None without one."""
        if self.arm is None:
            return None
        cameras, urdf = self.all_of(CameraSpec).values(), self.urdf_text()
        return next(
            (camera for camera in cameras if not joints_between(urdf, self.link_of(camera), "hand")), None
        )

    @cached_property
    def body_height(self) -> float:
        """Height of the top of the base's body (without arm and mounted parts) above the floor by the URDF,
        in [m].
        """
        from handcart.backends.urdf.robot_shape import body_height

        return body_height(self.urdf_text())

    @cached_property
    def tray_shape(self) -> TrayShape:
        """Shape of the tray by the URDF.

        Raises:
            MissingShape: the URDF has no tray (ValueError: the robot has no arm).
        """
        from handcart.backends.urdf.robot_shape import tray_shape

        return tray_shape(self.described_arm)

    @cached_property
    def finger_shape(self) -> FingerShape:
        """Shape of the fingers by the URDF.

        Raises:
            MissingShape: the URDF has no fingers (ValueError: the robot has no arm).
        """
        from handcart.backends.urdf.robot_shape import finger_shape

        return finger_shape(self.described_arm)

    def without_errors(self) -> RobotFile:
        """Return the robot with an error-free simulation, as with `errors: {none: true}` in its file."""
        ideal_sensors = {name: spec.without_errors() for name, spec in self.sensors.items()}
        return self.model_copy(update={"errors": Errors.nowhere()}).with_sensors(ideal_sensors)

    def posture(self, name: str) -> tuple[float, ...]:
        """Return a posture by its name, in [rad] or [m] for each joint; raise `UnknownPosture` if unknown."""
        if self.arm is None or name not in self.arm.postures:
            known = ", ".join(self.arm.postures) if self.arm else "none: the robot has no arm"
            raise UnknownPosture(f"the robot's file has no posture {name!r}; allowed: {known}")
        return self.joint_units.si(self.arm.postures[name])
