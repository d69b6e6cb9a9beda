"""Frames that a simulated robot's drivers publish by `tf`."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from handcart.backends.backend import Backend
from handcart.backends.capabilities.arm import Arm
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.description.ros_spec import RosSpec
from handcart.backends.robot.mounted_camera import camera_mount, known_camera, mount_of
from handcart.backends.ros2.wire.camera_topics import camera_topics, depth_topics
from handcart.backends.ros2.wire.frame_tree import lidar_pose
from handcart.backends.ros2.wire.messages import set_stamp
from handcart.backends.ros2.wire.ros_errors import NoRos
from handcart.backends.ros2.wire.ros_link import Link
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.geometry.transform import Transform, transform
from handcart.robotics.kinematics.urdf_frames import base_T_frame

FRAMES, STATIC_TOPIC, TOPIC = "tf2_msgs/TFMessage", "tf_static", "tf"


class BenchFrames:
    """Publisher of a simulated robot's frames on `tf_static` and `tf`.

    The frames of fixed sensors are published once. The frames of the base and of cameras are published every
    period while a node subscribes to `tf`.
    """

    def __init__(self, robot: RobotFile, spec: RosSpec, inner: Backend, link: Link) -> None:
        """Announce the topics `tf` and `tf_static`, if the package of their messages is installed.

        Args:
            robot: robot file.
            spec: its section `ros2`.
            inner: simulated robot, whose frames are published.
            link: the drivers' node.
        """
        self._robot, self._spec, self._link = robot, spec, link
        self._arm = inner.get(Arm)  # type: ignore[type-abstract]
        self._model = None if robot.arm is None else robot.arm_model()
        try:
            fixed = link.latched(FRAMES, STATIC_TOPIC)
            self.topics: Mapping[str, str] = {TOPIC: FRAMES}
        except NoRos:
            self.topics = {}
            return
        fixed(self._message(0.0, dict(self._fixed())))

    def moving(self, now: float, base: Pose2) -> Mapping[str, Any]:
        """Return the `tf` message with the frames of base and cameras, as a mapping with the topic as its
        key; empty if no node listens.

        Args:
            now: time of the message's stamps, in [s].
            base: 2D pose odom_T_base.
        """
        if not self.topics or not self._link.subscribers(TOPIC):
            return {}
        poses = {self._spec.odometry.child_frame: transform((base.x, base.y, 0.0), (0.0, 0.0, base.theta))}
        message = self._message(now, poses, self._spec.odometry.frame or "odom")
        message.transforms = [*message.transforms, *self._message(now, dict(self._cameras())).transforms]
        return {TOPIC: message}

    def _fixed(self) -> Iterator[tuple[str, Transform]]:
        robot = self._robot
        for frame, sensor in (("range_sensor", robot.range_sensor), ("imu", robot.imu), ("gps", robot.gps)):
            if sensor is not None:
                pose = base_T_frame(robot.urdf_text(), robot.link_of(sensor))
                is_lidar = sensor is robot.range_sensor
                yield frame, lidar_pose(pose, self._spec.lidar.upside_down) if is_lidar else pose

    def _cameras(self) -> Iterator[tuple[str, Transform]]:
        robot = self._robot
        for name, (camera, _) in camera_topics(robot, self._spec).items():
            known = known_camera(camera, mount_of(robot, camera, self._model))
            yield name, self._carrier(known.carrier) @ known.carrier_T_camera
        for name, (deep, _) in depth_topics(robot, self._spec).items():
            mount = camera_mount(robot, robot.link_of(deep), self._model)
            yield name, self._carrier(mount.carrier) @ mount.carrier_T_frame

    def _carrier(self, link: str) -> Transform:
        if self._model is None or self._arm is None:
            return base_T_frame(self._robot.urdf_text(), link)
        return self._model.forward(self._arm.joints(), link)

    def _message(self, now: float, poses: Mapping[str, Transform], parent: str = "") -> Any:
        """Return a `TFMessage` with the poses of frames in a parent frame.

        Args:
            now: time of its stamps, in [s].
            poses: parent_T_frame (4, 4) by the frame's name.
            parent: name of the parent frame; "": the frame of the base.
        """
        from scipy.spatial.transform import Rotation  # late: few runs need it

        message = self._link.message(FRAMES)
        for frame, pose in poses.items():
            one = self._link.message("geometry_msgs/TransformStamped")
            one.header.frame_id = parent or self._spec.odometry.child_frame
            one.child_frame_id = frame
            set_stamp(one.header, now)
            place, turn = one.transform.translation, one.transform.rotation
            place.x, place.y, place.z = map(float, pose[:3, 3])
            turn.x, turn.y, turn.z, turn.w = map(float, Rotation.from_matrix(pose[:3, :3]).as_quat())
            message.transforms = [*message.transforms, one]
        return message
