"""Move an arm and fingers by goals of actions through the middleware: `python -m benchmarks.ros2.goals`.

Each trial has a bench, which serves the actions, and a program in processes of their own. The program is
killed (SIGKILL) while its goals move the arm: the arm has to rest once the last goal ends. An action rejects,
aborts or cancels a goal, answers none, or another node sends one: the program has to end with a fault that
names the action, and the arm has to rest. A trial in which the machine was too slow for its loops is not
judged (`benchmarks.ros2.judged`). Needs rclpy and control_msgs. Status 1 if anything was missed.
"""

from __future__ import annotations

import argparse
import importlib.util
import random
import sys
import time
from multiprocessing.connection import Connection
from typing import NamedTuple

import numpy as np

from benchmarks.cut_off import CUT_OFF_STATUS, CutOff
from handcart.backends.backend import RobotFault
from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.gripper import Gripper
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.description.ros_spec import (
    RosArmSpec,
    RosGripperSpec,
    RosOdometrySpec,
    RosSpec,
    RosTopicSpec,
)
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.registry import make_backend
from handcart.backends.ros2.bench.bench_faults import ACTION_KINDS, TopicFault
from handcart.backends.ros2.bench.ros_bench import RosBench
from handcart.backends.ros2.ros_backend import RosBackend
from handcart.backends.ros2.wire.messages import TRAJECTORY_ACTION, trajectory_goal
from handcart.backends.ros2.wire.ros_link import RosLink
from handcart.evaluation.trials.rig import LIBRARY_FOLDER
from handcart.files.errors import HandcartError

from .judged import LoopWatch, Tally, Verdict
from .wire_rig import (
    FIRST_PERIODS,
    Ended,
    Process,
    Rest,
    await_driving,
    on_the_air,
    serve,
    warm_up,
    watching,
)

ARM, HAND = "arm_controller/follow_joint_trajectory", "gripper_controller/gripper_cmd"
RIVAL = "rival"
SPEED_RAD_S = 0.2
MAX_PERIODS = 4
"""Periods of the bench in which the arm may move after the end: that of its last goal, one on the way, and
two of a busy machine."""


class Trial(NamedTuple):
    """Result of a trial."""

    wrong: str
    """Why it counts as missed; "" if it doesn't."""
    rest: Rest = Rest(0.0, 0)
    """Rest of the arm after the program's end."""


def main() -> None:
    """Print a row for the kills, and one for each fault."""
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("--count", type=int, default=10, help="trials of each kind")
    kinds = ["killed", *ACTION_KINDS, RIVAL]
    words.add_argument("--kinds", nargs="+", choices=kinds, default=kinds, metavar="KIND")
    words.add_argument("--seed", type=int, default=0, help="of the instants")
    asked = words.parse_args()
    if importlib.util.find_spec("control_msgs") is None:
        sys.exit("not run: control_msgs is not installed; needed: a ROS distribution, or a build of it")
    warm_up()
    rng, missed, number = random.Random(asked.seed), 0, 0
    for kind in asked.kinds:
        found: list[Trial] = []
        verdicts: list[Verdict] = []
        with CutOff() as cut:
            for _ in range(asked.count):
                print(f"\r{kind}: {len(found)} of {asked.count}", end="", file=sys.stderr, flush=True)
                with on_the_air(number), watching() as watched:
                    trial = tried(kind, rng.uniform(0.0, 0.5))
                found.append(trial)
                verdicts.append(Verdict(trial.wrong, watched.late))
                number += 1
        print(file=sys.stderr)
        if not verdicts:
            sys.exit(CUT_OFF_STATUS)
        tally = Tally(verdicts)
        missed += tally.missed
        seconds = np.array([trial.rest.seconds for trial in found])
        print(
            f"{kind:<12}{'arm at rest' if kind == 'killed' else 'named, at rest'} {tally.words}"
            f"  median {np.median(seconds):.3f} s, at most {seconds.max():.3f} s"
            f" and {max(trial.rest.periods for trial in found)} periods after the end"
            f"{cut.words(len(verdicts), asked.count)}",
            flush=True,
        )
        for item in tally.findings():
            print(f"    {item}", flush=True)
        if cut.came:
            sys.exit(CUT_OFF_STATUS)
    sys.exit(1 if missed else 0)


def tried(kind: str, after_s: float) -> Trial:
    """Let a program move the arm, and something happen to it."""
    bench = Process(serve_arm)
    others: list[Process] = []
    try:
        bench.answer()
        driver = Process(swing_arm)
        others.append(driver)
        await_driving(driver)
        time.sleep(after_s)
        words = ARM
        if kind == "killed":
            ended_s = driver.kill()
        else:
            if kind == RIVAL:
                others.append(Process(_rival))
            else:
                bench.pipe.send(TopicFault(kind, ARM, 0.0))
            ended: Ended = driver.answer()
            ended_s, words = ended.time, ended.words
        time.sleep(0.6)
        bench.pipe.send(ended_s)
        rest: Rest = bench.answer()
    except TimeoutError as error:
        return Trial(str(error))
    finally:
        for other in (*others, bench):
            other.kill()
    wrong = "" if ARM in words else f"not named: {words}"
    # A rival's goal moves the arm on: it is not this program's.
    is_late = rest.periods > MAX_PERIODS and kind != RIVAL
    return Trial(wrong or (f"the arm moved for {rest.periods} periods" if is_late else ""), rest)


def librarian() -> RobotFile:
    """Return a robot whose arm and fingers take goals, without its camera.

    A bench that renders a picture in each period can't keep that period on a busy machine.
    """
    robot = load_robot("librarian")
    assert robot.arm is not None
    spec = RosSpec(
        arm=RosArmSpec(actions={ARM: robot.arm.joints}),
        gripper=RosGripperSpec(action=HAND),
        answer_ms=1000.0,
        odometry=RosOdometrySpec(stale_ms=2000.0),  # the machine may be busy
        joint_states=RosTopicSpec(topic="joint_states", stale_ms=2000.0),
        first_message_s=30.0,
        max_late_ms=1000.0,
        max_missed_periods=100,
    )
    return robot.model_copy(update={"ros2": spec, "camera": None}).read_in(robot.folder)


def serve_arm(pipe: Connection) -> None:
    """Serve the robot's topics and actions until killed; see `serve_bench`, for the arm."""
    robot = librarian()
    inner = make_backend("kinematic", robot, LIBRARY_FOLDER / "world.yaml", 0)
    arm = inner.get(Arm)  # type: ignore[type-abstract]
    assert arm is not None
    before = arm.command()

    def moves(_: RosBench) -> bool:
        nonlocal before
        before, then = arm.command(), before
        return bool(np.abs(before - then).max() > 1e-6)

    serve(pipe, robot, inner, moves)


def swing_arm(pipe: Connection) -> None:
    """Move a joint to and fro and the fingers, each period; send "drives", then how it ended."""
    words = "moved to its end"
    try:
        with RosBackend(librarian()) as backend:
            arm, gripper = backend.get(Arm), backend.get(Gripper)  # type: ignore[type-abstract]
            assert arm is not None and gripper is not None
            begun, step = arm.command(), SPEED_RAD_S * backend.period
            watch = LoopWatch(backend.period, FIRST_PERIODS + 1)
            for period in range(1200):
                way = period % 40 if period % 80 < 40 else 40 - period % 40
                arm.move(begun + step * way * np.eye(len(begun))[0])
                if period % 40 == 0:
                    gripper.move(0.03 if period % 80 else 0.05)
                backend.step()
                if period == FIRST_PERIODS:
                    pipe.send("drives")
                watch.note()
    except (RobotFault, HandcartError) as error:
        words = str(error)
    pipe.send(Ended(time.monotonic(), words, {}))


def _rival(pipe: Connection) -> None:
    """Send a goal to the arm, as another program does."""
    link, robot = RosLink("rival"), librarian()
    assert robot.arm is not None
    sender = link.goal_sender(TRAJECTORY_ACTION, ARM)
    while not sender.is_ready():
        time.sleep(0.05)
        link.receive()
    goal = trajectory_goal(link, sender, robot.arm.joints, [0.0] * len(robot.arm.joints), 5.0)
    sender.send(goal)
    while True:
        link.receive()
        time.sleep(0.05)


if __name__ == "__main__":
    main()
