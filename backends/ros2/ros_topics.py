"""All topics of a robot: readings in, commands out."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from typing import TypeVar

import numpy as np

from handcart.backends.capabilities.arm import ForceArm
from handcart.backends.capabilities.base import Base, DriveCommand, HolonomicBase
from handcart.backends.capabilities.camera import Camera
from handcart.backends.capabilities.capability import Capability
from handcart.backends.capabilities.depth_camera import DepthCamera
from handcart.backends.capabilities.gps import Gps
from handcart.backends.capabilities.gripper import Gripper
from handcart.backends.capabilities.imu import Imu
from handcart.backends.capabilities.range_sensor import RangeSensor
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.description.ros_spec import (
    RosDepthSpec,
    RosGripperSpec,
    RosSpec,
    RosTopicSpec,
)
from handcart.backends.plain_values import attributes, set_attributes
from handcart.backends.robot.mounted_camera import camera_mount, known_camera, mount_of
from handcart.backends.ros2.wire.messages import TRAJECTORY_ACTION, message_kind, velocity_message
from handcart.backends.ros2.wire.ros_link import Link, Take
from handcart.backends.saved_state import NotAState
from handcart.backends.sensors.depth_spec import DepthCameraSpec
from handcart.robotics.geometry.transform import Transform
from handcart.robotics.kinematics.urdf_frames import base_T_frame

from .cameras.ros_camera import RosCamera
from .cameras.ros_depth_camera import PictureTopic, RosDepthCamera
from .frame_odometry import FrameOdometry
from .goal_stream import GoalStream
from .joint_controllers import FingerController, JointController, TopicController, TrajectoryController
from .joint_states import JointStates
from .ros_arm import RosArm
from .ros_base import OdometryTopic, RosBase, RosHolonomicBase
from .ros_findings import ros_faults
from .ros_gps import RosGps
from .ros_gripper import RosGripper
from .ros_imu import RosImu
from .ros_lidar import RosLidar
from .wire.camera_topics import camera_topics, depth_topics
from .wire.ros_errors import WrongRosSection
from .wire.topic_sensor import TopicSensor
from .wrench_topic import WrenchTopic

SensorT = TypeVar("SensorT", bound=TopicSensor)


class RosTopics:
    """Capabilities (base, arm, gripper and sensors) of a robot that is connected over ROS.

    The topics and actions of the robot's drivers are those of the section `ros2` of the robot's file.
    """

    def __init__(self, robot: RobotFile, spec: RosSpec, link: Link) -> None:
        """Subscribe to all readings, and announce all commands.

        Raises:
            NoRos: the package of a message is not installed.
        """
        self._robot, self._spec, self._link = robot, spec, link
        self.sensors: list[TopicSensor] = []
        """All subscribed readings."""
        self.commands: dict[str, str] = {}
        """Type of the message of each topic that is published."""
        self.streams: list[GoalStream] = []
        """All actions to which goals are sent."""
        self._controllers: dict[tuple[str, ...], JointController] = {}
        kind_of_odometry = FrameOdometry if spec.odometry.type == "TFMessage" else OdometryTopic
        odometry = self._heard(kind_of_odometry, "the odometry", spec.odometry)
        self.odometry = odometry
        kind = RosHolonomicBase if robot.drive.kind == "holonomic" else RosBase
        self.base = kind(robot.drive, odometry, spec.odometry)
        self._drive = self._publisher(f"geometry_msgs/{spec.velocity.type}", spec.velocity.topic)
        self._fingers: JointController | None = None
        self.states = self._joint_states()
        self.arm, self.gripper = self._made_arm(), self._made_gripper()
        self._sensors = tuple(self._made_sensors())

    def capabilities(self) -> tuple[Capability, ...]:
        """Return the robot's base, its arm and gripper if it has them, and its sensors with ROS topics."""
        actuators = (item for item in (self.base, self.arm, self.gripper) if item is not None)
        return (*actuators, *self._sensors)

    def begin(self) -> None:
        """Start commanding arm and gripper at their measured positions; to be called when each topic has had
        a message.
        """
        for item in (self.arm, self.gripper, *self.streams):
            if item is not None:
                item.begin()

    def advance(self) -> None:
        """Process the messages that have arrived in a period."""
        for sensor in self.sensors:
            sensor.advance()
        for stream in self.streams:
            stream.advance()
        states = self.states
        if self.gripper is not None and states is not None and states.is_fresh and not states.missing:
            self.gripper.advance()

    def state(self) -> dict[str, object]:
        """Return, for a checkpoint, the commands and readings that later messages do not repeat, as plain
        data.
        """
        return {name: attributes(part, part.STATE) for name, part in self._kept().items()}

    def set_state(self, state: object, receive: Callable[[], None]) -> None:
        """Restore a state that `state` returned.

        Args:
            state: result of `state`.
            receive: function that delivers the messages that were published at the time of that state.

        Raises:
            NotAState: the state belongs to another robot.
        """
        kept = self._kept()
        if not isinstance(state, dict) or state.keys() != kept.keys():
            raise NotAState(f"no state of this robot's topics; needed: {', '.join(kept)}")
        set_attributes(self.odometry, OdometryTopic.STATE, state["odometry"])
        receive()
        self.advance()
        for name, part in kept.items():
            set_attributes(part, part.STATE, state[name])

    def forget(self) -> None:
        """Discard all received and all waiting messages, and stop monitoring the goals that were sent."""
        self._link.receive()
        for sensor in self.sensors:
            sensor.forget()
        for stream in self.streams:
            stream.forget()

    def _kept(self) -> dict[str, OdometryTopic | RosArm | RosGripper]:
        parts = {"odometry": self.odometry, "arm": self.arm, "gripper": self.gripper}
        return {name: part for name, part in parts.items() if part is not None}

    def halt(self) -> None:
        """Drop all commands that have not been sent; arm and gripper hold their positions."""
        self.base.taken()
        for controller in self._controllers.values():
            controller.cancel()
        for item in (self.arm, self.gripper):
            if item is not None:
                item.halt()

    def stop_base(self) -> None:
        """Publish zero speed to the base at once, without waiting for the next period."""
        self._drive(velocity_message(self._link, self._spec.velocity, DriveCommand()))

    def send(self) -> None:
        """Publish the commands of a period.

        The base's command is always sent, because without new commands the base stops after a time-out; other
        commands are sent only if they have changed.
        """
        self._drive(velocity_message(self._link, self._spec.velocity, self.base.taken()))
        joints = None if self.arm is None else self.arm.taken()
        if joints is not None and self._robot.arm is not None:
            self._send_arm(dict(zip(self._robot.arm.joints, joints.tolist(), strict=True)))
        fingers = None if self.gripper is None else self.gripper.taken()
        if fingers is not None and self._fingers is not None and self.gripper is not None:
            self._fingers.send(self._spec.gripper.joints, fingers, self.gripper.seconds())

    def _send_arm(self, positions: Mapping[str, float]) -> None:
        """Send each controller the positions of its joints, in [rad] or [m] by their names in the robot's
        file.
        """
        seconds = self._robot.period_s + self._spec.arm.latency_ms / 1e3
        for joints, controller in self._controllers.items():
            names = [self._spec.name_of(joint) for joint in joints]
            values = [self._spec.sign_of(joint) * positions[joint] for joint in joints]
            controller.send(names, values, seconds)

    def _joint_states(self) -> JointStates | None:
        arm = () if self._robot.arm is None else self._robot.arm.joints
        fingers = () if self._robot.gripper is None else self._spec.gripper.joints
        if not arm and not fingers:
            return None
        states = self._heard(JointStates, "the joints", self._spec.joint_states)
        signs = [*map(self._spec.sign_of, arm), *(1.0 for _ in fingers)]
        states.expect([*map(self._spec.name_of, arm), *fingers], signs)
        return states

    def _made_arm(self) -> RosArm | None:
        spec = self._robot.arm
        if spec is None or self.states is None:
            return None
        wrench = None
        if self._spec.wrench is not None:
            wrench = self._heard(WrenchTopic, "the force at the hand", self._spec.wrench)
        topics, actions = self._spec.arm.joints_by_topic(spec.joints), self._spec.arm.actions
        for topic, joints in topics.items():
            self._controllers[joints] = self._topic_controller(self._spec.arm.type, topic)
        for action, joints in actions.items():
            stream = self._stream(TRAJECTORY_ACTION, action)
            self._controllers[joints] = TrajectoryController(self._link, stream)
        names, model = [self._spec.name_of(joint) for joint in spec.joints], self._robot.arm_model()
        speeds = np.maximum(model.velocity, self._robot.joint_speeds())
        self.states.limit(names, np.where(self._robot.joint_units.endless, math.inf, speeds))
        return RosArm(model, names, self.states, wrench, self._robot.period_s)

    def _made_gripper(self) -> RosGripper | None:
        spec, topic = self._robot.gripper, self._spec.gripper
        if spec is None or self.states is None:
            return None
        self._fingers = self._finger_controller(topic)
        return RosGripper(spec, topic, self.states, topic.joints, self._robot.period_s)

    def _made_sensors(self) -> Iterator[Capability]:
        robot, spec = self._robot, self._spec
        if robot.range_sensor is not None:
            lidar = self._heard(RosLidar, "the lidar", spec.lidar)
            mount = base_T_frame(robot.urdf_text(), robot.lidar_link)
            lidar.fit(robot.range_sensor, mount, spec.lidar.upside_down)
            lidar.sensor_name = robot.name_of(robot.range_sensor)
            yield lidar
        for name, (camera, topic) in camera_topics(robot, spec).items():
            label = "the camera" if camera is robot.camera else f"the camera {name}"
            heard = self._heard(RosCamera, label, topic)
            heard.fit(known_camera(camera, mount_of(robot, camera)))
            heard.sensor_name = name
            yield heard
        for name, (deep, topics) in depth_topics(robot, spec).items():
            yield self._depth_camera(name, deep, topics)
        if robot.imu is not None:
            unit = self._heard(RosImu, "the inertial unit", spec.imu)
            unit.sensor_name = robot.name_of(robot.imu)
            yield unit
        if robot.gps is not None and spec.gps is not None:
            receiver = self._heard(RosGps, "the satellite receiver", spec.gps)
            receiver.fit(spec.gps, robot.gps.period_s)
            receiver.sensor_name = robot.name_of(robot.gps)
            yield receiver

    def _depth_camera(self, name: str, spec: DepthCameraSpec, topics: RosDepthSpec) -> RosDepthCamera:
        robot, arm = self._robot, self._robot.arm
        mount = camera_mount(robot, robot.link_of(spec), None if arm is None else robot.arm_model())
        model, states = None if arm is None else robot.arm_model(), self.states
        names = () if arm is None else tuple(map(self._spec.name_of, arm.joints))

        def pose(stamp: float) -> Transform:
            if model is None or states is None:
                return base_T_frame(robot.urdf_text(), mount.carrier) @ mount.carrier_T_frame
            joints = states.positions_at(names, stamp)
            return model.forward(joints, mount.carrier) @ mount.carrier_T_frame

        colours = RosTopicSpec(topic=topics.colour, stale_ms=topics.stale_ms)
        depth = self._heard(PictureTopic, f"the depth of {name}", topics)
        colour = self._heard(PictureTopic, f"the colours of {name}", colours)
        camera = RosDepthCamera(spec, depth, colour, pose, self._link.now())
        camera.sensor_name = name
        return camera

    def _heard(self, kind: type[SensorT], name: str, source: RosTopicSpec) -> SensorT:
        link = self._link
        sensor = kind(name, source, link.now if self._spec.same_clock else None, link.clock)
        self._link.subscribe(kind.KIND, source.topic, sensor.heard)
        self.sensors.append(sensor)
        return sensor

    def _finger_controller(self, spec: RosGripperSpec) -> JointController:
        if spec.action is None:
            return self._topic_controller(spec.type, spec.topic)
        stream = self._stream(f"control_msgs/{spec.action_type}", spec.action, may_miss=True)
        if spec.action_type == "GripperCommand":
            return FingerController(stream, spec.max_effort_n)
        return TrajectoryController(self._link, stream)

    def _topic_controller(self, kind: str, topic: str) -> JointController:
        self.commands[topic] = message_kind(kind)
        return TopicController(self._link, kind, topic)

    def _stream(self, kind: str, name: str, may_miss: bool = False) -> GoalStream:
        sender, answer = self._link.goal_sender(kind, name), self._spec.answer_ms / 1e3
        self.streams.append(GoalStream(sender, name, kind, answer, self._link.clock, may_miss))
        return self.streams[-1]

    def _publisher(self, kind: str, topic: str) -> Take:
        self.commands[topic] = kind
        return self._link.publisher(kind, topic)


def command_topics(robot: RobotFile, spec: RosSpec) -> tuple[str, ...]:
    """Return the names of the topics to which commands are published, without those of actions."""
    arm, fingers = robot.arm, spec.gripper
    of_arm = () if arm is None else tuple(spec.arm.joints_by_topic(arm.joints))
    of_fingers = () if robot.gripper is None or fingers.action is not None else (fingers.topic,)
    return (spec.velocity.topic, *of_arm, *of_fingers)


def check_ros_section(robot: RobotFile, spec: RosSpec) -> None:
    """Raise `WrongRosSection` if the section `ros2` of the robot's file has faults (see `ros_faults`).

    Such faults are a joint that the arm lacks, a joint with no or several controllers, and an incomplete
    description of a camera or a satellite receiver.
    """
    wrong = [": ".join(["ros2", *map(str, key[:1]), words]) for key, words, _ in ros_faults(robot, spec)]
    if wrong:
        raise WrongRosSection(wrong)


def capabilities_of(robot: RobotFile) -> tuple[type[Capability], ...]:
    """Return the classes of the capabilities that a robot has over ROS according to its file."""
    there: dict[type[Capability], object] = {
        HolonomicBase if robot.drive.kind == "holonomic" else Base: robot.drive,
        ForceArm: robot.arm,
        Gripper: robot.gripper,
        RangeSensor: robot.range_sensor,
        Camera: robot.camera,
        Imu: robot.imu,
        Gps: robot.gps,
    }
    deep = robot.ros2 is not None and bool(depth_topics(robot, robot.ros2))
    there[DepthCamera] = True if deep else None
    return tuple(kind for kind, what in there.items() if what is not None)
