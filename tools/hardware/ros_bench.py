"""`handcart bench --ros2`: a simulated robot behind topics, as a process of its own."""

from __future__ import annotations

import sys
import time
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from handcart.backends.backend import Backend
    from handcart.backends.description.robot_file import RobotFile


class RosBenchOptions(NamedTuple):
    """Options for simulating a robot behind ROS 2 topics: robot, world, faults, duration and others."""

    robot: str | None
    """Name or path of the robot; None: that of the task."""
    backend: str
    """Name of the simulated backend."""
    world: Path | None
    task: Path | None
    """A task, which names world and start, and the robot where none is named."""
    seed: int
    faults: tuple[str, ...]
    """Injected faults, each as KIND@TOPIC@SECONDS."""
    seconds: float | None
    """Duration in [s]; None: until Ctrl-C."""
    wrong: tuple[str, ...] = ()
    """Differences of the robot from its file, each as NAME=FACTOR."""


def serve_topics(options: RosBenchOptions) -> None:
    """Simulate a robot behind its ROS 2 topics in real time.

    Raises:
        InputError: the robot, backend, world or a fault is unknown.
        NoRos: rclpy is not installed.
    """
    from handcart.backends.ros2.bench.bench_faults import BenchFaults, TopicFault
    from handcart.backends.ros2.bench.bench_rate import BenchRate
    from handcart.backends.ros2.bench.robot_differences import RobotDifferences
    from handcart.backends.ros2.bench.ros_bench import RosBench
    from handcart.backends.ros2.wire.ros_errors import NoTopics
    from handcart.backends.ros2.wire.ros_link import RosLink, node_name
    from handcart.tools.terminal.asked_to_end import AskedToEnd

    planned = tuple(map(TopicFault.read, options.faults))
    spec, inner = simulated_robot(options)
    with ExitStack() as parts:  # closed here unless the bench owns them
        parts.callback(inner.close)
        if spec.ros2 is None:
            raise NoTopics(spec.folder)
        differences = RobotDifferences.read(options.wrong, spec, spec.ros2)
        link = RosLink(node_name("bench"), spec.ros2.namespace, spec.ros2.domain)
        parts.callback(link.close)
        bench = RosBench(spec, spec.ros2, inner, link, BenchFaults(spec.period_s, planned), differences)
        parts.pop_all()
    over, rate = AskedToEnd(), BenchRate(spec.period_s)
    begun = due = time.monotonic()
    where = f"topics of {spec.ros2.namespace or '/'}"
    print(
        f"{where}: {options.robot or spec.folder.name}, simulated by {options.backend}; Ctrl-C ends",
        flush=True,
    )
    try:
        while not over and not (options.seconds is not None and due - begun >= options.seconds):
            bench.step()
            if words := rate.note(time.monotonic()):
                print(words, file=sys.stderr, flush=True)
            due = max(due + spec.period_s, time.monotonic() - spec.period_s)
            time.sleep(max(0.0, due - time.monotonic()))
    finally:
        bench.close()


def list_topic_faults() -> None:
    """Print the faults that can be injected into a robot simulated behind ROS 2 topics."""
    from handcart.backends.ros2.bench.bench_faults import FAULT_KINDS
    from handcart.backends.ros2.bench.robot_differences import FIXED_NAMES

    for name, words in FAULT_KINDS.items():
        print(f"{name:<12} {words}")
    print("differences of the robot from its file, as --wrong NAME=FACTOR:")
    for name, words in {**FIXED_NAMES, "JOINT": "factor of a joint's command and reading"}.items():
        print(f"{name:<18} {words}")


def simulated_robot(options: RosBenchOptions) -> tuple[RobotFile, Backend]:
    """Return the robot's file and the simulated robot."""
    from handcart.backends.loading.robot_loading import load_robot
    from handcart.backends.registry import make_backend
    from handcart.evaluation.trials.rig import LIBRARY_FOLDER
    from handcart.networks.task.preparing import prepare
    from handcart.tasks.task_names import task_path

    if options.task is not None:
        settings = {} if options.robot is None else {"robot": options.robot}
        prepared = prepare(task_path(options.task), options.backend, settings, options.seed)
        return prepared.robot.spec, prepared.backend
    assert options.robot is not None, "without a task it has a default"
    spec = load_robot(options.robot)
    world = options.world or LIBRARY_FOLDER / "world.yaml"
    return spec, make_backend(options.backend, spec, world, options.seed)
