"""A robot as it is heard for some seconds."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from typing import Any

from handcart.backends.description.robot_file import RobotFile
from handcart.backends.description.ros_spec import RosSpec
from handcart.backends.ros2.on_the_air import unheard
from handcart.backends.ros2.ros_topics import RosTopics
from handcart.backends.ros2.wire.camera_topics import info_topics
from handcart.backends.ros2.wire.frame_tree import FrameTree
from handcart.backends.ros2.wire.ros_errors import NoRos
from handcart.backends.ros2.wire.topic_sensor import TopicSensor
from handcart.robotics.geometry.pose2 import Pose2

from .listening_link import ListeningLink

CAMERA_INFO, FRAMES = "sensor_msgs/CameraInfo", "tf2_msgs/TFMessage"


class HeardRobot:
    """Messages received during a check of a running robot, from the topics that the robot's file names."""

    def __init__(
        self,
        robot: RobotFile,
        spec: RosSpec,
        topics: RosTopics,
        link: ListeningLink,
        over: Callable[[], bool] | None = None,
    ) -> None:
        """Prepare to listen to a robot.

        Args:
            robot: the robot's file.
            spec: section `ros2` of that file.
            topics: topics of that section.
            link: connection to these topics.
            over: returns True once a recording is over, in which the robot may drive; None: no recording.
        """
        self._over = over
        self.frames = FrameTree()
        """Frames by `tf` and `tf_static`."""
        self.has_frames = self._listen_to_frames(link)
        """Whether the messages of `tf` are installed."""
        self.robot, self.spec, self.topics, self.link = robot, spec, topics, link
        self.refusals: dict[str, Counter[str]] = {}
        """Why readings of a topic were refused, each with a count, by the topic."""
        self.first_pose: Pose2 | None = None
        """Odometry's pose odom_T_base at the beginning of the measurement; None without one."""
        for topic in info_topics(robot, spec):
            link.subscribe(CAMERA_INFO, topic, lambda message: None)

    def _listen_to_frames(self, link: ListeningLink) -> bool:
        try:
            link.subscribe_unmeasured(FRAMES, "tf_static", self.frames.take_static, latched=True)
            link.subscribe_unmeasured(FRAMES, "tf", self.frames.take)
        except NoRos:
            return False
        return True

    def wait_for_all(self, wait: Callable[[], None], seconds: float) -> None:
        """Wait until each topic has had a message and each command topic has a subscriber, or time is over.

        Args:
            wait: function that waits for a short time.
            seconds: longest wait, in [s].
        """
        end = self.link.clock() + seconds
        while self.link.clock() < end and not self._is_complete() and not self._ended():
            self._receive(wait)

    def measure(self, wait: Callable[[], None], seconds: float) -> None:
        """Measure rate, gaps and ages of all topics for a time, beginning with this call.

        Args:
            wait: function that waits for a short time.
            seconds: duration, in [s].
        """
        self.refusals.clear()
        for sensor in self.topics.sensors:
            sensor.rejected = 0
        for meter in self.link.meters.values():
            meter.begin()
        self.first_pose = self.topics.odometry.pose
        end = self.link.clock() + seconds
        while self.link.clock() < end and not self._ended():
            self._receive(wait)

    @property
    def may_drive(self) -> bool:
        """True if the messages come from a recording, in which the robot may drive; a live robot must be at
        rest.
        """
        return self._over is not None

    def _ended(self) -> bool:
        return self._over is not None and self._over()

    def last(self, topic: str) -> Any:
        """Return the last message of a topic; None before the first."""
        return self.link.meters[topic].last

    def sensors(self) -> Iterator[tuple[str, TopicSensor]]:
        """Yield pairs: a key in the section `ros2` of the robot's file, and the topic that it describes.

        Only topics with readings of sensors are yielded.
        """
        keys = {id(getattr(self.spec, key)): key for key in type(self.spec).model_fields}
        keys |= {id(camera): "cameras" for camera in self.spec.cameras.values()}
        keys |= {id(item): "depth" for item in self.spec.depth.values()}
        for sensor in self.topics.sensors:
            yield keys.get(id(sensor.source), "depth"), sensor  # colours have no key of their own

    def _is_complete(self) -> bool:
        topics = self.topics
        joints = topics.states is None or not topics.states.missing
        return (
            joints
            and all(sensor.age is not None for sensor in topics.sensors)
            and not unheard(topics, self.link)
        )

    def _receive(self, wait: Callable[[], None]) -> None:
        wait()
        self.link.receive()
        for sensor in self.topics.sensors:
            before = sensor.rejected
            sensor.advance()
            if sensor.rejected > before:
                why = sensor.doubt or "its stamps are out of order"
                self.refusals.setdefault(sensor.source.topic, Counter())[why] += sensor.rejected - before
