"""A simulated robot behind topics, as a real robot's drivers would have them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, ClassVar, TypeVar

import numpy as np

from handcart.backends.backend import Backend
from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.base import Base, DriveCommand, HolonomicBase, WheelTravel
from handcart.backends.capabilities.camera import Camera
from handcart.backends.capabilities.capability import Capability
from handcart.backends.capabilities.depth_camera import DepthCamera
from handcart.backends.capabilities.gripper import Gripper
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.description.ros_spec import RosSpec
from handcart.backends.hand_force import efforts_of_force
from handcart.backends.plain_values import Kinds, attributes, set_attributes
from handcart.backends.robot.mounted_camera import camera_model
from handcart.backends.ros2.wire.camera_topics import camera_topics, depth_topics
from handcart.backends.ros2.wire.messages import SRDF_TOPIC, TRAJECTORY_ACTION, URDF_TOPIC
from handcart.backends.ros2.wire.ros_link import Link
from handcart.backends.urdf.robot_parts import read_srdf
from handcart.robotics.far import Far
from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.numerics.arrays import FloatArray

from .bench_faults import BenchFaults
from .bench_frames import BenchFrames
from .bench_messages import (
    camera_info_message,
    depth_messages,
    image_message,
    imu_message,
    odometry_message,
    scan_message,
    state_message,
)
from .bench_receiver import BenchReceiver
from .late_commands import LateCommands
from .local_air import LocalLink
from .robot_differences import RobotDifferences
from .served_joints import ServedJoints
from .wheel_odometry import WheelOdometry

CapabilityT = TypeVar("CapabilityT", bound=Capability)
COMMAND_TIMEOUT_S = 0.25
"""Time without a command after which the base of the bench stops, as a real one must, in [s]."""


class RosBench:
    """ROS drivers of a simulated robot, which execute received commands and publish sensor readings."""

    STATE: ClassVar[Kinds] = {
        "time": float,
        "_command": DriveCommand,
        "_commanded": Far,
        "_wanted": dict[str, float],
    }

    def __init__(
        self,
        robot: RobotFile,
        spec: RosSpec,
        inner: Backend,
        link: Link,
        faults: BenchFaults | None = None,
        differences: RobotDifferences | None = None,
    ) -> None:
        """Connect a simulated robot to topics.

        Args:
            robot: the robot's file.
            spec: its section `ros2`.
            inner: the simulated robot, owned by the bench from now on.
            link: the drivers' node, owned by the bench from now on.
            faults: planned faults of the topics; None: none.
            differences: how the simulated robot differs from the file; None: it doesn't.

        Raises:
            InputError: a planned fault names a topic or an action that the bench has not.
        """
        self._robot, self._spec, self.inner, self._link = robot, spec, inner, link
        self._faults = faults or BenchFaults(robot.period_s)
        self._true = differences or RobotDifferences()
        self._base = inner.get(Base)  # type: ignore[type-abstract]
        self._arm = inner.get(Arm)  # type: ignore[type-abstract]
        self._gripper = inner.get(Gripper)  # type: ignore[type-abstract]
        self._model: ArmModel | None = robot.arm_model() if self._arm is not None else None
        self.time = 0.0
        """Simulated time, in [s]."""
        self._command, self._commanded = DriveCommand(), -math.inf
        self._wanted: dict[str, float] = {}
        self._late = LateCommands(round(self._true.joint_latency_s / robot.period_s))
        self._late_fingers = LateCommands(round(self._true.finger_latency_s / robot.period_s))
        self._wheels = WheelOdometry(robot.drive)
        self._frames = BenchFrames(robot, spec, inner, link)
        self._satellites = BenchReceiver(robot, spec, inner, link)
        self._send = self._publishers()
        self._served: tuple[ServedJoints, ...] = ()
        self._listen()
        self._check_faults()
        self._describe()

    def step(self) -> None:
        """Execute the commands that have arrived, simulate one control period, and publish the readings."""
        self._link.receive()
        measured = dict(zip(*self._joint_readings()[:2], strict=True)) if self._served else {}
        for joints in self._served:
            self._wanted.update(joints.wanted(self.time, self.inner.period, measured))
        if self._base is not None:
            self._drive()
        if self._arm is not None:
            self._move_arm(self._arm)
        if self._gripper is not None:
            self._move_fingers(self._gripper)
        self.inner.step()
        self.time += self.inner.period
        self._settle()
        self._publish()

    def _settle(self) -> None:
        """End the goals of actions that are reached or can't be."""
        if not self._served:
            return
        measured = dict(zip(*self._joint_readings()[:2], strict=True))
        presses = self._gripper is not None and self._gripper.closed_on_something()
        for joints in self._served:
            joints.settle(self.time, measured, presses)

    def announce(self) -> None:
        """Publish the robot's present readings again, without simulating a further control period."""
        self._publish()

    def state(self) -> dict[str, object]:
        """Return the state of the simulated ROS drivers for a checkpoint, without that of the simulated
        robot's body.
        """
        return {
            "drivers": attributes(self, self.STATE),
            "wheels": attributes(self._wheels, WheelOdometry.STATE),
            **{joints.name: attributes(joints, joints.STATE) for joints in self._served},
        }

    def set_state(self, state: Mapping[str, object]) -> None:
        """Restore a state of the drivers that `state` returned."""
        set_attributes(self, self.STATE, state["drivers"])
        set_attributes(self._wheels, WheelOdometry.STATE, state["wheels"])
        for joints in self._served:
            set_attributes(joints, joints.STATE, state[joints.name])
        self._satellites.begin(self.time)

    def close(self) -> None:
        """Close the connection to the topics and the simulated robot."""
        self._link.close()
        self.inner.close()

    @property
    def speeds(self) -> DriveCommand:
        """Speeds at which the simulated base is driving now; zero if the last command is older than the
        base's time-out.
        """
        late = self.time - self._commanded > self._true.timeout(COMMAND_TIMEOUT_S)
        return DriveCommand() if late else self._command

    def _check_faults(self) -> None:
        self._faults.check(self._kinds(), [joints.name for joints in self._served])

    def _describe(self) -> None:
        """Publish the URDF, and the SRDF if there is one, as robot_state_publisher and MoveIt do."""
        texts = {URDF_TOPIC: self._robot.urdf_text()}
        if self._robot.srdf is not None:
            texts[SRDF_TOPIC] = read_srdf(self._robot.srdf, self._robot.folder)
        for topic, text in texts.items():
            message = self._link.message("std_msgs/String")
            message.data = text
            self._link.latched("std_msgs/String", topic)(message)

    def _listen(self) -> None:
        spec, link = self._spec, self._link
        link.subscribe(f"geometry_msgs/{spec.velocity.type}", spec.velocity.topic, self._heard_velocity)
        if self._arm is not None:
            for topic, joints in self._controllers().items():
                self._listen_joints(topic, spec.arm.type, list(map(spec.name_of, joints)))
            self._serve(TRAJECTORY_ACTION, spec.arm.actions)
        if self._gripper is not None and spec.gripper.action is not None:
            kind = f"control_msgs/{spec.gripper.action_type}"
            self._serve(kind, {spec.gripper.action: spec.gripper.joints})
        elif self._gripper is not None:
            self._listen_joints(spec.gripper.topic, spec.gripper.type, list(spec.gripper.joints))

    def _serve(self, kind: str, actions: Mapping[str, Sequence[str]]) -> None:
        for name, joints in actions.items():
            names = [self._spec.name_of(joint) for joint in joints]
            self._served += (ServedJoints(self._link, kind, name, names, self._faults),)

    def _listen_joints(self, topic: str, kind: str, names: list[str]) -> None:
        def heard(message: Any) -> None:
            if kind == "Float64MultiArray":
                self._wanted.update(zip(names, message.data, strict=True))
            elif message.points:
                self._wanted.update(zip(message.joint_names, message.points[-1].positions, strict=True))

        package = "trajectory_msgs" if kind == "JointTrajectory" else "std_msgs"
        self._link.subscribe(f"{package}/{kind}", topic, heard)

    def _heard_velocity(self, message: Any) -> None:
        twist = message.twist if self._spec.velocity.type == "TwistStamped" else message
        factor = self._true.factor
        self._command = DriveCommand(
            twist.linear.x * factor("velocity.forward"),
            twist.angular.z * factor("velocity.turn"),
            twist.linear.y * factor("velocity.sideways"),
        )
        self._commanded = self.time

    def _drive(self) -> None:
        """Pass the commanded speeds on to the simulated base, within its limits."""
        drive, asked = self._robot.drive, self.speeds
        top, top_turn = drive.top_speed_m_s, math.radians(drive.top_turn_deg_s)
        speed = min(max(asked.speed, -top), top)
        turn = min(max(asked.turn_rate, -top_turn), top_turn)
        if isinstance(self._base, HolonomicBase):
            self._base.drive(speed, turn, min(max(asked.sideways, -drive.top_sideways), drive.top_sideways))
        elif self._base is not None:
            self._base.drive(speed, turn)

    def _move_arm(self, arm: Arm) -> None:
        """Move each joint towards its last commanded point as fast as it can."""
        if self._robot.arm is None or self._model is None:
            return
        held = arm.command()
        wanted, asked = held.copy(), self._late.passed(self._wanted)
        for place, joint in enumerate(self._robot.arm.joints):
            target = asked.get(self._spec.name_of(joint))
            if target is not None:
                wanted[place] = self._spec.sign_of(joint) * target / self._true.factor(joint)
        most = np.minimum(self._model.velocity, self._robot.joint_speeds()) * self.inner.period
        arm.move(self._model.clipped(np.clip(wanted, held - most, held + most)))

    def _move_fingers(self, gripper: Gripper) -> None:
        spec, file = self._spec.gripper, self._robot.gripper
        asked = self._late_fingers.passed(self._wanted)
        positions = [asked[name] for name in spec.joints if name in asked]
        if file is None or not positions:
            return
        opening = file.opening_mm / 1e3
        width = (float(np.mean(positions)) - spec.closed) / self._per_m()
        if abs(width - gripper.command()) > 1e-9:
            gripper.move(min(max(0.0, width), opening))

    def _publish(self) -> None:
        now = self._link.now()
        for topic, message in self._readings(now).items():
            for item in self._faults.passed(topic, message, self.time):
                self._send[topic](item)

    def _readings(self, now: float) -> Mapping[str, Any]:
        """Return the messages of a period by their topics."""
        spec, link, robot = self._spec, self._link, self._robot
        found: dict[str, Any] = {}
        if self._base is not None:
            travel = self._reported(self._base.wheel_travel())
            pose, speeds = self._wheels.moved(travel, self.inner.period)
            if spec.odometry.type == "Odometry":
                found[spec.odometry.topic] = odometry_message(link, now, pose, speeds)
            found |= self._frames.moving(now, pose)
        names, positions, efforts = self._joint_readings()
        if names:
            found[spec.joint_states.topic] = state_message(link, now, names, positions, efforts)
        if robot.range_sensor is not None:
            factor, side = self._true.factor("scan"), self._true.factor("scan.side")
            found[spec.lidar.topic] = scan_message(
                link, now, robot.range_sensor, self.inner, factor, side < 0.0, spec.lidar.upside_down
            )
        if robot.imu is not None:
            found[spec.imu.topic] = imu_message(link, now, self.inner, self._true.factor("imu"))
        found |= self._satellites.messages(now, self.time)
        found |= self._pictures(now)
        return found

    def _pictures(self, now: float) -> Mapping[str, Any]:
        """Return the messages of all cameras to which somebody listens."""
        link, found = self._link, dict[str, Any]()
        late = isinstance(link, LocalLink) and not self._faults.any_planned
        for name, (camera, topic) in camera_topics(self._robot, self._spec).items():
            seen = self._camera(name, Camera)  # type: ignore[type-abstract]
            if seen is not None and link.subscribers(topic.topic):
                found[topic.topic] = image_message(link, now, seen, late, name)
            if link.subscribers(topic.info_topic):
                found[topic.info_topic] = camera_info_message(link, now, camera_model(camera))
        for name, (deep, topics) in depth_topics(self._robot, self._spec).items():
            seeing = self._camera(name, DepthCamera)  # type: ignore[type-abstract]
            if seeing is not None and link.subscribers(topics.topic):
                both = depth_messages(link, now, seeing, late, name, self._true.factor("depth"))
                found[topics.topic], found[topics.colour] = both
            if link.subscribers(topics.info_topic):
                found[topics.info_topic] = camera_info_message(link, now, deep.model)
        return found

    def _camera(self, name: str, kind: type[CapabilityT]) -> CapabilityT | None:
        """Return a simulated camera by its name in the robot's file."""
        named = self.inner.sensor(name)
        return named if isinstance(named, kind) else self.inner.get(kind)

    def _reported(self, travel: WheelTravel) -> WheelTravel:
        """Return the wheels' travel, in [m], as the odometry reports it, with the planned differences."""
        forward = 0.5 * (travel.left + travel.right) * self._true.factor("odometry.forward")
        turn = 0.5 * (travel.right - travel.left) * self._true.factor("odometry.turn")
        return WheelTravel(forward - turn, forward + turn, travel.sideways)

    def _joint_readings(self) -> tuple[list[str], list[float], list[float]]:
        """Return names in ROS, positions in [rad] or [m] and efforts in [Nm] or [N] of all joints."""
        names: list[str] = []
        positions: list[float] = []
        efforts: list[float] = []
        if self._arm is not None and self._robot.arm is not None and self._model is not None:
            joints = self._arm.joints()
            for joint, angle, effort in zip(
                self._robot.arm.joints, joints, self._efforts(self._model, self._arm, joints), strict=True
            ):
                names.append(self._spec.name_of(joint))
                positions.append(self._spec.sign_of(joint) * self._true.state_factor(joint) * float(angle))
                efforts.append(self._spec.sign_of(joint) * float(effort))
        if self._gripper is not None:
            spec = self._spec.gripper
            position = spec.closed + self._per_m() * self._gripper.width()
            names += spec.joints
            positions += [position] * len(spec.joints)
            efforts += [0.0] * len(spec.joints)
        return names, positions, efforts

    def _efforts(self, model: ArmModel, arm: Arm, joints: FloatArray) -> FloatArray:
        return efforts_of_force(model, joints, arm.hand_force())

    def _controllers(self) -> Mapping[str, tuple[str, ...]]:
        arm = self._robot.arm
        return self._spec.arm.joints_by_topic(() if arm is None else arm.joints)

    def _per_m(self) -> float:
        """Return the travel of each finger's joint, in [rad] or [m], for a metre of opening."""
        spec, file = self._spec.gripper, self._robot.gripper
        opening = 1.0 if file is None else file.opening_mm / 1e3
        per_m = ((0.5 * opening if spec.open is None else spec.open) - spec.closed) / opening
        return per_m * self._true.factor("gripper")

    def _publishers(self) -> Mapping[str, Any]:
        return {topic: self._link.publisher(kind, topic) for topic, kind in self._kinds().items()}

    def _kinds(self) -> Mapping[str, str]:
        """Return the message type of each topic of readings."""
        spec = self._spec
        return {
            **({spec.odometry.topic: "nav_msgs/Odometry"} if spec.odometry.type == "Odometry" else {}),
            **self._frames.topics,
            spec.joint_states.topic: "sensor_msgs/JointState",
            spec.lidar.topic: "sensor_msgs/LaserScan",
            spec.imu.topic: "sensor_msgs/Imu",
            **self._picture_kinds(),
            **({} if spec.gps is None else {spec.gps.topic: "sensor_msgs/NavSatFix"}),
        }

    def _picture_kinds(self) -> Mapping[str, str]:
        """Return the type of each topic of the cameras."""
        found: dict[str, str] = {}
        for _, topic in camera_topics(self._robot, self._spec).values():
            found |= {topic.topic: "sensor_msgs/Image", topic.info_topic: "sensor_msgs/CameraInfo"}
        for _, topics in depth_topics(self._robot, self._spec).values():
            found |= {topics.topic: "sensor_msgs/Image", topics.info_topic: "sensor_msgs/CameraInfo"}
            found[topics.colour] = "sensor_msgs/Image"
        return found
