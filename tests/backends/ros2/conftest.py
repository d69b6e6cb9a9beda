"""A robot by topics in front of the kinematic backend, all in this process."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from handcart.backends.description.robot_file import RobotFile
from handcart.backends.description.ros_spec import RosSpec
from handcart.backends.kinematic.kinematic_backend import KinematicBackend
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.ros2.bench.bench_faults import BenchFaults, TopicFault
from handcart.backends.ros2.bench.local_bench import LocalBench
from handcart.backends.ros2.ros_backend import RosBackend

WORLD = Path(__file__).parents[3] / "tasks" / "return_book" / "world.yaml"
Make = Callable[..., RosBackend]


@pytest.fixture
def make() -> Make:
    """Return a function that builds a robot by topics: its name, faults, and keys of the section `ros2`."""

    def made(
        name: str = "librarian", faults: tuple[str, ...] = (), ideal: bool = False, **ros2: object
    ) -> RosBackend:
        robot: RobotFile = load_robot(name)
        robot = robot.without_errors() if ideal else robot
        spec = RosSpec(**ros2)  # type: ignore[arg-type]
        robot = robot.model_copy(update={"ros2": spec}).read_in(robot.folder)
        inner = KinematicBackend.build(robot, WORLD, 0)
        planned = tuple(map(TopicFault.read, faults))
        return RosBackend(robot, LocalBench(robot, spec, inner, BenchFaults(robot.period_s, planned)))

    return made
