"""Report of `handcart check ROBOT --ros2`: the robot's file against the topics on the air."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from handcart.backends.description.robot_names import robot_path
from handcart.files.errors import InputError
from handcart.files.yaml.yaml_document import read_document

from .check_robot import lines_of

if TYPE_CHECKING:
    from handcart.backends.ros2.air_check.air_report import AirReport

LISTENING_S = 5.0


def air_facts(
    name: str, bench: str | None = None, seconds: float = LISTENING_S, bag: Path | None = None
) -> dict[str, Any]:
    """Listen to a robot's ROS 2 topics, and return what was received and, as `errors`, the differences from
    the robot's file.

    Args:
        name: name of the robot, or path of its file.
        bench: name of a simulated backend that publishes the topics in this process; None: topics of a real
            robot.
        seconds: time in [s] to listen.
        bag: a recorded bag whose topics are read instead.

    Raises:
        FileError: the robot's files are wrong.
        InputError: the robot's file has no section `ros2`, or `bench` is not a simulated backend.
        NoRos: rclpy is not installed.
    """
    from handcart.backends.loading.robot_loading import load_robot
    from handcart.backends.registry import bench_class
    from handcart.backends.ros2.air_check.air_report import listen
    from handcart.backends.ros2.air_check.connected import connected
    from handcart.backends.ros2.ros_backend import RosBackend
    from handcart.backends.ros2.wire.ros_errors import NoTopics
    from handcart.evaluation.bag_playing.recorded_report import recorded_report
    from handcart.evaluation.trials.rig import LIBRARY_FOLDER

    robot = load_robot(name)
    if robot.ros2 is None:
        raise NoTopics(robot.folder)
    if bag is not None and bench is not None:
        raise InputError("a bag and a bench; allowed: one of both")
    if bag is not None:
        report = recorded_report(robot, robot.ros2, bag, seconds)
    else:
        inner = None
        if bench is not None:
            inner = bench_class(bench, RosBackend.name).build(robot, LIBRARY_FOLDER / "world.yaml", 0)
        with connected(robot, robot.ros2, inner) as (link, wait):
            report = listen(robot, robot.ros2, link, wait, seconds)
    document = read_document(robot_path(name))
    return {
        "format": robot.format,
        "errors": [document.finding(fault.key, fault.words) for fault in report.faults],
        "warnings": [str(document.finding(remark.key, remark.words)) for remark in report.remarks],
        "lines": lines_of(_table(report)),
        "robot": {"topics": [topic._asdict() for topic in report.topics], "nodes": report.nodes},
    }


def _table(report: AirReport) -> Any:
    """Return a table of the topics for people."""
    from handcart.tools.terminal.tables import table_of

    rows = [
        (
            item.topic,
            item.kind,
            f"{item.rate_hz:.1f} Hz" if item.rate_hz else "-",
            f"{1e3 * item.max_gap_s:.0f} ms" if item.messages else "-",
            "-" if item.age_s is None else f"{1e3 * item.age_s:.1f} ms",
            ", ".join(item.frames),
            _names(report.nodes[item.topic]),
        )
        for item in report.topics
    ]
    known = {item.topic for item in report.topics}
    rows += [
        (
            topic,
            "command",
            "-",
            "-",
            "-",
            "",
            ", ".join(dict.fromkeys(name.rpartition(" ")[0] for name in nodes)),
        )
        for topic, nodes in report.nodes.items()
        if topic not in known
    ]
    return table_of("topic", "message", "rate", "longest gap", "age", "frame", "nodes", rows=rows)


def _names(nodes: list[str]) -> str:
    """Return the names of nodes, each once and without its type."""
    return ", ".join(dict.fromkeys(name.rpartition(" ")[0] for name in nodes))
