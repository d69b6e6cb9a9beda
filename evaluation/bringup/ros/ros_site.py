"""Site of a bring-up by ROS 2: a robot's topics, or a bench."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

from typing_extensions import override

from handcart.backends.backend import Backend
from handcart.backends.description.ros_spec import RosSpec
from handcart.backends.registry import bench_class
from handcart.backends.ros2.air_check.connected import connected
from handcart.backends.ros2.bench.local_bench import LocalBench
from handcart.backends.ros2.bench.robot_differences import RobotDifferences
from handcart.backends.ros2.ros_backend import RosBackend
from handcart.backends.ros2.wire.ros_errors import NoTopics
from handcart.backends.ros2.wire.ros_link import Link
from handcart.evaluation.bringup.site import RobotSite
from handcart.networks.runs.robot_claim import claimed


@dataclass
class RosSite(RobotSite):
    """Robot to bring up that is connected by ROS topics, or a simulated robot as bench in this process."""

    differences: RobotDifferences = field(default_factory=RobotDifferences)
    """Differences between the bench's robot and the file."""

    @property
    @override
    def backend_name(self) -> str:
        return RosBackend.name

    @property
    def spec(self) -> RosSpec:
        """Return the section `ros2` of the robot's file.

        Raises:
            NoTopics: the file has no such section.
        """
        if self.robot.ros2 is None:
            raise NoTopics(self.robot.folder)
        return self.robot.ros2

    @property
    @override
    def fingerprint(self) -> str:
        tried = self.robot.model_dump_json(include={"ros2", "period_s", "drive", "arm", "gripper"})
        return hashlib.sha256((tried + self.robot.urdf_text()).encode()).hexdigest()[:16]

    @contextmanager
    def air(self) -> Iterator[tuple[Link, Callable[[], None]]]:
        """Yield a connection to the topics of the robot's running drivers, and a function that waits briefly
        while messages arrive.
        """
        inner = self._simulated(0) if self.bench else None
        with connected(self.robot, self.spec, inner, self.differences) as both:
            yield both

    @contextmanager
    def backend(self, seed: int = 0) -> Iterator[RosBackend]:
        """Yield the backend of the robot at rest, after a message of each topic has arrived.

        A real robot is reserved for this process meanwhile.
        """
        bench = None
        if self.bench:
            inner = self._simulated(seed)
            bench = LocalBench(self.robot, self.spec, inner, differences=self.differences)
        made = RosBackend(self.robot, bench)
        try:
            with claimed(made):
                yield made
        finally:
            made.close()

    def _simulated(self, seed: int) -> Backend:
        return bench_class(self.bench, RosBackend.name).build(self.robot, self.world, seed)
