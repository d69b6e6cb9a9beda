"""Connection to a robot by ROS 2: the section `ros2` of its file.

Every key has the usual name as its default: `ros2: {}` fits a robot that follows the conventions of
ros2_control and Nav2.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from handcart.files.models.model import FileModel

Topic = Annotated[str, Field(pattern=r"^[~/]?[A-Za-z_][A-Za-z0-9_/]*$", max_length=200)]
StaleTime = Annotated[float, Field(gt=0.0, le=10_000.0)]
"""Age in [ms] beyond which a message is stale."""
JointName = Annotated[str, Field(min_length=1, max_length=200)]


class RosTopicSpec(FileModel):
    """A ROS topic that the robot's drivers publish, with name, frame and largest age of its messages."""

    topic: Topic
    """Name of the topic, relative to the namespace of the program."""
    frame: str | None = None
    """Expected `header.frame_id`; a message from another frame is refused (default: the frame of the
    first message; not checked for joints)."""
    stale_ms: StaleTime = 300.0
    """Age of the last message, by its arrival and by its stamp, beyond which it is stale."""


class RosOdometrySpec(RosTopicSpec):
    """ROS topic of the wheel odometry, and the largest plausible motion between two of its messages."""

    topic: Topic = "odom"
    type: Literal["Odometry", "TFMessage"] = "Odometry"
    """`Odometry` of `nav_msgs`, or `TFMessage` of `tf2_msgs` (topic `tf`) where no topic has the odometry."""
    child_frame: str = "base_link"
    """Frame of the base, for `TFMessage` and for comparisons with `tf`."""
    jump_factor: Annotated[float, Field(ge=1.0, le=100.0)] = 3.0
    """Ratio of the motion between two messages to that at top speed, above which it is a jump."""
    jump_m: Annotated[float, Field(ge=0.0, le=10.0)] = 0.1
    """Distance added to the limit of a jump that `jump_factor` sets."""
    jump_deg: Annotated[float, Field(ge=0.0, le=180.0)] = math.degrees(0.2)
    """Angle added to the limit of a jump that `jump_factor` sets."""


class RosLidarSpec(RosTopicSpec):
    """ROS topic of a lidar's scans, and the way in which the lidar is mounted."""

    topic: Topic = "scan"
    upside_down: bool = False
    """True for a lidar mounted upside down, whose driver counts the angles clockwise as seen from above. The
    frame in the robot's file stays upright, with the same x axis."""


class RosGpsSpec(RosTopicSpec):
    """ROS topic of a satellite receiver's fixes, and the point on Earth that is the origin of positions."""

    topic: Topic = "fix"
    stale_ms: StaleTime = 2000.0
    origin_lat_deg: Annotated[float, Field(ge=-89.0, le=89.0)]
    """Latitude of the task's origin, north positive (WGS 84)."""
    origin_lon_deg: Annotated[float, Field(ge=-180.0, le=180.0)]
    """Longitude of the task's origin, east positive (WGS 84)."""
    sigma_m: Annotated[float, Field(gt=0.0, le=100.0)] = 2.5
    """Sigma of a fix on each axis, if its message states none."""
    silent_without_fix: bool = False
    """True for a driver that publishes nothing while it has no fix, such as gpsd_client with
    `check_fix_by_variance`: then only the end of its node is noticed, and not its silence."""


class RosLensSpec(RosTopicSpec):
    """ROS topic of a camera's pictures, and the topic of the camera's calibration."""

    info: Topic | None = None
    """Topic of the camera's calibration (default: `camera_info` beside the pictures)."""

    @property
    def info_topic(self) -> str:
        """Name of the topic with the camera's calibration."""
        folder = self.topic.rpartition("/")[0]
        return self.info or (f"{folder}/camera_info" if folder else "camera_info")


class RosCameraSpec(RosLensSpec):
    """Description, in a robot's file, of the ROS topics of a grey or colour camera."""

    topic: Topic = "camera/image_raw"
    stale_ms: StaleTime = 1000.0


class RosDepthSpec(RosLensSpec):
    """ROS topics with a depth camera's depth and colour pictures in one pixel grid, and the topic of their
    calibration.
    """

    topic: Topic = "camera/aligned_depth_to_color/image_raw"
    """Depth (`16UC1` in mm, or `32FC1` in m)."""
    colour: Topic = "camera/color/image_raw"
    """Colours, of the same size."""
    stale_ms: StaleTime = 1000.0


class RosVelocitySpec(FileModel):
    """ROS topic of the commands to the base (forward speed, sideways speed and turn rate)."""

    topic: Topic = "cmd_vel"
    type: Literal["Twist", "TwistStamped"] = "Twist"
    """Message of `geometry_msgs`; ros2_control takes `TwistStamped`."""
    frame: str = "base_link"
    """`header.frame_id` of a `TwistStamped`."""


DEFAULT_ARM_TOPIC = "arm_controller/joint_trajectory"


class RosArmSpec(FileModel):
    """Topics and actions of the arm's controllers, as the section `ros2` of a robot's file states them."""

    controllers: dict[Topic, tuple[JointName, ...]] = Field(default_factory=dict)
    """Joints of each controller by its command topic, by the names of the robot's file (default: all joints
    of the arm by `arm_controller/joint_trajectory`).
    """
    actions: dict[Topic, tuple[JointName, ...]] = Field(default_factory=dict)
    """Joints of each controller that takes goals of `control_msgs/FollowJointTrajectory` instead, by the name
    of its action.
    """
    type: Literal["JointTrajectory", "Float64MultiArray"] = "JointTrajectory"
    """`JointTrajectory` for a trajectory controller, `Float64MultiArray` for a forward command controller."""
    latency_ms: Annotated[float, Field(ge=0.0, le=1000.0)] = 0.0
    """Time by which the points of a trajectory are set later, because some controllers refuse past ones."""

    def joints_by_topic(self, joints: tuple[str, ...]) -> Mapping[str, tuple[str, ...]]:
        """Return the joints of each controller by its command topic.

        Args:
            joints: names of all joints of the arm; without controllers in the file they have the default
                topic.
        """
        return self.controllers if self.controllers or self.actions else {DEFAULT_ARM_TOPIC: joints}


class RosGripperSpec(FileModel):
    """ROS topic or action of the gripper's controller, and the joint positions at which the fingers are open,
    are closed, or press on an object.
    """

    topic: Topic = "gripper_controller/joint_trajectory"
    action: Topic | None = None
    """Name of the action by which the gripper is commanded instead of a topic."""
    action_type: Literal["GripperCommand", "FollowJointTrajectory"] = "GripperCommand"
    """Type of the action, of `control_msgs`."""
    max_effort_n: Annotated[float, Field(ge=0.0, le=1000.0)] = 0.0
    """Force for which a `GripperCommand` asks; many controllers take 0 as their own limit."""
    type: Literal["JointTrajectory", "Float64MultiArray"] = "JointTrajectory"
    joints: tuple[JointName, ...] = ("left_finger", "right_finger")
    """Names in ROS of the fingers' joints, in the order of the controller's messages."""
    closed: float = 0.0
    """Position of each joint, in [rad] or [m], at which the fingers meet."""
    open: float | None = None
    """Position of each joint, in [rad] or [m], at the full opening (default: half of the opening)."""
    press_mm: Annotated[float, Field(gt=0.0, le=50.0)] = 1.0
    """Opening beyond the commanded one from which something is between resting fingers."""
    rest_percent: Annotated[float, Field(gt=0.0, le=100.0)] = 20.0
    """Share of the gripper's speed below which the fingers rest."""
    rest_ms: Annotated[float, Field(ge=0.0, le=5000.0)] = 150.0
    """Time of rest after which fingers away from their command press."""

    @model_validator(mode="after")
    def _has_one_way(self) -> Self:
        if self.action is not None and (also := sorted({"topic", "type"} & self.model_fields_set)):
            raise ValueError(f"action and {', '.join(also)}; allowed: an action, or a topic with its type")
        needing = sorted({"action_type", "max_effort_n"} & self.model_fields_set)
        if self.action is None and needing:
            raise ValueError(f"{', '.join(needing)} without an action; needed: the key action")
        return self


class RosSpec(FileModel):
    """Section `ros2` of a robot's file, with topics and actions of its ROS 2 drivers, and time limits."""

    domain: Annotated[int, Field(ge=0, le=232)] | None = None
    """ROS domain (default: by the variable ROS_DOMAIN_ID)."""
    namespace: Annotated[str, Field(pattern=r"^(/[A-Za-z_][A-Za-z0-9_]*)*$")] = ""
    """Namespace of the topics."""
    velocity: RosVelocitySpec = RosVelocitySpec()
    odometry: RosOdometrySpec = RosOdometrySpec()
    """Odometry of the wheels (`nav_msgs/Odometry`)."""
    joint_states: RosTopicSpec = RosTopicSpec(topic="joint_states")
    names: dict[JointName, JointName] = Field(default_factory=dict)
    """Names in ROS of joints that are called otherwise in the robot's file."""
    reversed: tuple[JointName, ...] = ()
    """Joints of the robot's file that count the other way round in ROS."""
    arm: RosArmSpec = RosArmSpec()
    gripper: RosGripperSpec = RosGripperSpec()
    wrench: RosTopicSpec | None = None
    """Force on the hand (`geometry_msgs/WrenchStamped`, in the hand frame); None: by the joints' efforts."""
    lidar: RosLidarSpec = RosLidarSpec()
    camera: RosCameraSpec = RosCameraSpec()
    cameras: dict[str, RosCameraSpec] = Field(default_factory=dict)
    """Topics of further cameras by their names in the table `sensors`; `camera` is that of the first."""
    depth: dict[str, RosDepthSpec] = Field(default_factory=dict)
    """Topics of depth cameras by their names in the table `sensors`."""
    imu: RosTopicSpec = RosTopicSpec(topic="imu")
    gps: RosGpsSpec | None = None
    """Satellite receiver (`sensor_msgs/NavSatFix`); needed if the robot has one."""
    same_clock: bool = True
    """True if the robot's clock is in step with this machine's: then a message is also refused whose stamp
    is older than its `stale_ms`, or as far in the future.
    """
    answer_ms: StaleTime = 300.0
    """Time in which an action has to accept a goal; without an answer the robot is stopped."""
    max_late_ms: Annotated[float, Field(gt=0.0, le=1000.0)] = 100.0
    """Time by which a period of this program may end late before the robot is stopped. For that long, and
    a period more, the base keeps its last speeds.
    """
    max_missed_periods: Annotated[int, Field(ge=1, le=100)] = 3
    """Number of late periods in a row at which the robot is stopped."""
    first_message_s: Annotated[float, Field(gt=0.0, le=120.0)] = 10.0
    """Time in which the first message of each topic has to arrive."""

    def name_of(self, joint: str) -> str:
        """Return the name that a joint of the robot's file has in ROS messages."""
        return self.names.get(joint, joint)

    def sign_of(self, joint: str) -> float:
        """Return -1 for a joint whose position has the opposite sign in ROS messages, otherwise 1."""
        return -1.0 if joint in self.reversed else 1.0
