"""Connection to a robot's topics: on the air, or of a bench in this process."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager

from handcart.backends.backend import Backend
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.description.ros_spec import RosSpec
from handcart.backends.ros2.bench.local_bench import LocalBench
from handcart.backends.ros2.bench.robot_differences import RobotDifferences
from handcart.backends.ros2.wire.ros_link import Link, RosLink, node_name

PAUSE_S = 0.005
"""Time between two looks for messages, in [s]."""


@contextmanager
def connected(
    robot: RobotFile | None,
    spec: RosSpec,
    inner: Backend | None = None,
    differences: RobotDifferences | None = None,
) -> Iterator[tuple[Link, Callable[[], None]]]:
    """Open a connection to a robot's topics; yield it with a function that waits for a short time.

    Args:
        robot: the robot's file; may be None if `inner` is None.
        spec: section `ros2` of that file.
        inner: simulated robot whose topics exist in this process only, closed at the end; None: the topics of
            the ROS network.
        differences: how the simulated robot differs from the file.

    Raises:
        NoRos: rclpy is not installed.
    """
    if inner is not None and robot is not None:
        with ExitStack() as parts:
            parts.callback(inner.close)
            local = LocalBench(robot, spec, inner, differences=differences)
            parts.callback(local.close)
            yield local.link, local.step
        return
    link = RosLink(node_name("check"), spec.namespace, spec.domain)
    try:
        yield link, lambda: time.sleep(PAUSE_S)
    finally:
        link.close()
