"""Let programs that nobody here wrote use the bench: `python -m benchmarks.ros2.counterparts`.

The bench runs in a process of its own. The command-line tools of ROS 2 (`ros2 topic`, `ros2 action
send_goal`, `ros2 node`) list, read, measure and command it; `--tools` is the path of `ros2`. With
`--other PYTHON`, the interpreter of another distribution drives it and reads its topics, by rclpy alone. A
tool that is not installed is named, and counts as not run. Needs rclpy. Status 1 if anything failed; Ctrl-C
prints the row of what was tried until then, status 130.
"""

from __future__ import annotations

import argparse
import importlib.util
import json
import os
import re
import shutil
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, NamedTuple

from benchmarks.cut_off import CUT_OFF_STATUS, CutOff
from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.base import Base
from handcart.backends.description.ros_spec import RosArmSpec, RosSpec
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.registry import make_backend
from handcart.backends.ros2.bench.ros_bench import RosBench
from handcart.backends.ros2.wire.ros_link import RosLink, node_name
from handcart.evaluation.trials.rig import LIBRARY_FOLDER

from .wire_rig import Process, on_the_air

ACTION = "arm_controller/follow_joint_trajectory"
OTHER_SIDE = Path(__file__).with_name("other_side.py")
TOOL_TIMEOUT_S, OTHER_S = 60.0, 8.0
TWIST = "{linear: {x: 0.2}}"


class State(NamedTuple):
    """Where the simulated robot is."""

    travel_m: float
    joint: float
    """Of the first joint, in [rad] or [m]."""


class Tool(NamedTuple):
    """One use of a command-line tool."""

    words: Sequence[str]
    expects: Callable[[str, State, State], bool]
    """Returns whether its output, and the robot before and after it, are as they should be."""
    shows: str
    """Regular expression of the part of the output that is printed."""
    seconds: float = TOOL_TIMEOUT_S
    """Time in [s] after which it is ended: some never end by themselves."""


def main() -> None:
    """Print a row for the tools, and one for the other distribution."""
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("--tools", default=shutil.which("ros2"), help="path of `ros2` (default: as installed)")
    words.add_argument("--other", nargs="*", default=[], help="interpreters of other distributions")
    asked = words.parse_args()
    print("starting the bench", file=sys.stderr, flush=True)
    with on_the_air(7):
        wrong = 0 if asked.tools is None else try_tools(asked.tools)
        if asked.tools is None:
            print(
                "command-line tools of ROS 2: not run: `ros2` is not installed; no wheel of it is published"
            )
        for python in asked.other:
            wrong += try_other(python)
        if not asked.other:
            print("another distribution: not run: no interpreter was named by --other")
    sys.exit(1 if wrong else 0)


def try_tools(ros2: str) -> int:
    """Use each tool once; return the number that failed."""
    has_actions = importlib.util.find_spec("control_msgs") is not None
    bench = Process(serve_robot, has_actions)
    done, failed, tools = 0, list[Tool](), list[Tool]()
    try:
        with CutOff() as cut:
            names = bench.answer()
            tools = tools_for(names, has_actions)
            for tool in tools:
                failed += [] if try_tool(ros2, tool, bench) else [tool]
                done += 1
    finally:
        bench.kill()
        run_tool([ros2, "daemon", "stop"], TOOL_TIMEOUT_S)  # some of them leave one
    without = "" if has_actions else "; actions not run: control_msgs is not installed"
    rest = cut.words(done, len(tools))
    print(f"command-line tools of ROS 2: {done - len(failed)} of {done} work{without}{rest}", flush=True)
    if cut.came:
        sys.exit(CUT_OFF_STATUS)
    return len(failed)


def try_tool(ros2: str, tool: Tool, bench: Process) -> bool:
    """Use a tool once, print what it showed, and return whether it worked."""
    before = state_of(bench)
    said = run_tool([ros2, *tool.words], tool.seconds)
    good = tool.expects(said, before, state_of(bench))
    shown = re.search(tool.shows, said)
    print(
        f"  {'works ' if good else 'FAILED'} ros2 {' '.join(tool.words)[:70]}:"
        f" {' '.join(shown.group(0).split())[:90] if shown else said.strip()[-200:]}",
        flush=True,
    )
    return good


def tools_for(joints: Sequence[str], has_actions: bool) -> list[Tool]:
    """Return all uses of the tools; `joints` are the arm's."""
    goal = json.dumps(
        {
            "trajectory": {
                "joint_names": list(joints),
                "points": [{"positions": [0.1] * len(joints), "time_from_start": {"sec": 3}}],
            }
        }
    )
    direct = ["--no-daemon", "--spin-time", "4"]
    found = [
        Tool(["topic", "list", *direct], lambda said, *_: has(said, "/odom", "/scan", "/cmd_vel"), "/scan"),
        Tool(["node", "list", *direct], lambda said, *_: "/handcart_bench" in said, "/handcart_bench.*"),
        Tool(
            ["topic", "info", "/scan", "-v", *direct],
            lambda said, *_: has(said, "sensor_msgs/msg/LaserScan", "Publisher count: 1"),
            "Publisher count: .*",
        ),
        Tool(
            ["topic", "echo", "/joint_states", "sensor_msgs/msg/JointState", "--once"],
            lambda said, *_: has(said, "joint_1", "position:"),
            r"- joint_1",
        ),
        Tool(
            ["topic", "hz", "/odom", "--window", "40"],
            lambda said, *_: 5.0 < last_number(said, "average rate") < 25.0,
            r"average rate: [\d.]+",
            15.0,
        ),
        Tool(
            ["topic", "pub", "-r", "10", "-t", "20", "/cmd_vel", "geometry_msgs/msg/Twist", TWIST],
            lambda said, before, after: after.travel_m - before.travel_m > 0.1,
            r"publishing #20.*",
        ),
    ]
    if has_actions:
        kind = "control_msgs/action/FollowJointTrajectory"
        found += [
            Tool(["action", "list", "-t"], lambda said, *_: has(said, f"/{ACTION}", kind), f"/{ACTION}.*"),
            Tool(
                ["action", "send_goal", f"/{ACTION}", kind, goal],
                lambda said, before, after: "SUCCEEDED" in said and abs(after.joint - 0.1) < 0.02,
                "Goal finished with status: .*",
            ),
            Tool(
                ["action", "send_goal", f"/{ACTION}", kind, "{}"],
                lambda said, before, after: "rejected" in said and abs(after.joint - before.joint) < 1e-3,
                "Goal was rejected.*",
            ),
        ]
    return found


def try_other(python: str) -> int:
    """Let another distribution's interpreter drive the bench; return 1 if it failed."""
    bench = Process(serve_robot, False)
    try:
        with CutOff() as cut:
            bench.answer()
            before = state_of(bench)
            said = run_tool([python, str(OTHER_SIDE), str(OTHER_S)], TOOL_TIMEOUT_S)
            after = state_of(bench)
    finally:
        bench.kill()
    if cut.came:
        print(f"another distribution, {python}: not run to its end (cut off)", flush=True)
        sys.exit(CUT_OFF_STATUS)
    try:
        report = json.loads(said.strip().splitlines()[-1])
    except (ValueError, IndexError):
        print(f"another distribution, {python}: FAILED: {said.strip()[-300:]}")
        return 1
    way, turn = after.travel_m - before.travel_m, after.joint - before.joint
    good = (
        report["odometry"] > 40
        and report["beams"] == 360
        and way > 0.5
        and abs(report["driven_m"] - way) < 0.1
        and abs(turn - 0.1) < 0.02
    )
    print(
        f"another distribution, rclpy {report['rclpy']}, Python {report['python']}:"
        f" {'works' if good else 'FAILED'}: {report['odometry']} odometry,"
        f" {report['scans']} scans of {report['beams']} beams, {report['joint_states']} joint states;"
        f" drove {report['driven_m']:.2f} m by odometry, {way:.2f} m truly; moved a joint by {turn:.3f}",
        flush=True,
    )
    return 0 if good else 1


def serve_robot(pipe: Connection, has_actions: bool) -> None:
    """Serve a robot's topics until killed; send the arm's joints, then each question's `State`."""
    robot = load_robot("librarian")
    assert robot.arm is not None
    arm = RosArmSpec(actions={ACTION: robot.arm.joints}) if has_actions else RosArmSpec()
    robot = robot.model_copy(update={"ros2": RosSpec(arm=arm)}).read_in(robot.folder)
    assert robot.ros2 is not None
    assert robot.arm is not None
    inner = make_backend("kinematic", robot, LIBRARY_FOLDER / "world.yaml", 0)
    bench = RosBench(robot, robot.ros2, inner, RosLink(node_name("bench")))
    base, joints = inner.get(Base), inner.get(Arm)  # type: ignore[type-abstract]
    assert base is not None
    assert joints is not None
    pipe.send(robot.arm.joints)
    due = time.monotonic()
    while True:
        bench.step()
        while pipe.poll():
            pipe.recv()
            travel = base.wheel_travel()
            pipe.send(State(0.5 * (travel.left + travel.right), float(joints.joints()[0])))
        due = max(due + robot.period_s, time.monotonic() - robot.period_s)
        time.sleep(max(0.0, due - time.monotonic()))


def state_of(bench: Process) -> State:
    """Return where the simulated robot is."""
    bench.pipe.send("state")
    state: State = bench.answer()
    return state


def run_tool(words: Sequence[str], seconds: float) -> str:
    """Return all that a program prints until its end, or until it is interrupted after some seconds."""
    environment: dict[str, Any] = {
        key: value for key, value in os.environ.items() if key not in ("LD_LIBRARY_PATH", BOOTSTRAPPED)
    }
    environment["PYTHONUNBUFFERED"] = "1"
    with subprocess.Popen(
        list(words), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=environment
    ) as program:
        try:
            return program.communicate(timeout=seconds)[0]
        except subprocess.TimeoutExpired:
            program.terminate()
            return program.communicate()[0]


BOOTSTRAPPED = "_ROS_WHEELS_BOOTSTRAP_COMPLETE"
"""Variable by which a program of ROS's wheels knows that it found its libraries."""


def has(said: str, *parts: str) -> bool:
    """Return whether each part was said."""
    return all(part in said for part in parts)


def last_number(said: str, name: str) -> float:
    """Return the last number of a name that was said; 0 without one."""
    found = re.findall(rf"{name}: ([\d.]+)", said)
    return float(found[-1]) if found else 0.0


if __name__ == "__main__":
    main()
