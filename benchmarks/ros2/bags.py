"""Play recorded bags into the backend `ros2`: `python -m benchmarks.ros2.bags`.

A robot on the bench drives and moves its arm; all its topics are recorded by `rosbags` in both storages of
rosbag2 (SQLite, MCAP), and played into another backend. Counted are the periods in which all readings are
those that came over the air, to the last bit. Then one topic of the bag is spoiled, and the backend has to
name it: another frame, old stamps, one stamp again and again, NaN. `--bag PATH --robot ROBOT` plays a bag
of yours instead and says what differs from the robot's file. Needs the extra `bags`. Status 1 if anything
differs or was missed.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Callable, Iterator
from itertools import product
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import numpy as np

from benchmarks.cut_off import CUT_OFF_STATUS, CutOff
from handcart.backends.backend import RobotFault
from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.base import Base
from handcart.backends.capabilities.camera import Camera
from handcart.backends.capabilities.range_sensor import RangeSensor
from handcart.backends.description.ros_spec import RosSpec, RosTopicSpec
from handcart.backends.kinematic.kinematic_backend import KinematicBackend
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.ros2.bench.local_bench import LocalBench
from handcart.backends.ros2.ros_backend import RosBackend
from handcart.backends.ros2.wire.ros_errors import NotOnTheAir
from handcart.evaluation.bag_playing.bag_link import BagLink
from handcart.evaluation.bag_playing.played_bag import PlayedBag
from handcart.evaluation.bag_playing.recorded_report import recorded_report
from handcart.evaluation.trials.rig import LIBRARY_FOLDER
from handcart.files.errors import InputError

from .bag_recorder import BagRecorder, Spoil

STORAGES = ("SQLITE3", "MCAP")
TOPICS = {
    "odom": "nav_msgs/Odometry",
    "joint_states": "sensor_msgs/JointState",
    "scan": "sensor_msgs/LaserScan",
    "camera/image_raw": "sensor_msgs/Image",
    "camera/camera_info": "sensor_msgs/CameraInfo",
}
JOINT_STEP_RAD = 0.005
SPOILED_S = 1.5
"""Time of the bench from which a topic is spoiled."""


class Reading(NamedTuple):
    """All readings of a period."""

    left: float
    right: float
    joints: tuple[float, ...]
    ranges: bytes
    picture: bytes


def main() -> None:
    """Print a row for each storage."""
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("--storages", nargs="+", default=list(STORAGES))
    words.add_argument("--periods", type=int, default=60, help="of the drive that is recorded")
    words.add_argument("--kinds", nargs="+", default=list(SPOILS), help="of spoiled bags")
    words.add_argument(
        "--topics", nargs="+", default=["odom", "scan", "joint_states"], help="that are spoiled"
    )
    words.add_argument("--bag", type=Path, help="a bag of yours")
    words.add_argument("--robot", default="librarian", help="whose file it is compared with")
    asked = words.parse_args()
    if asked.bag is not None:
        sys.exit(play_foreign(asked.bag, asked.robot))
    wrong = 0
    for storage in asked.storages:
        cut = CutOff()
        with TemporaryDirectory(prefix="bags-") as folder:
            same, missed, tried = measure(
                Path(folder), storage, asked.periods, asked.kinds, asked.topics, cut
            )
        wrong += (same < asked.periods) + len(missed)
        print(
            f"{storage:<9}{same} of {asked.periods} periods read as over the air, to the last bit;"
            f" spoiled: {tried - len(missed)} of {tried} named"
            f"{cut.words(tried, len(asked.kinds) * len(asked.topics))}",
            flush=True,
        )
        for item in missed:
            print(f"    {item}", flush=True)
        if cut.came:
            sys.exit(CUT_OFF_STATUS)
    sys.exit(1 if wrong else 0)


def measure(
    folder: Path, storage: str, periods: int, kinds: list[str], topics: list[str], cut: CutOff
) -> tuple[int, list[str], int]:
    """Return the number of periods that read alike, what was missed, and the number of spoiled bags.

    `cut` ends the trials with spoiled bags early.
    """
    print(f"{storage}: recording", file=sys.stderr, flush=True)
    live = record(folder / "whole", storage, periods, None)
    same = sum(a == b for a, b in zip(live, played(folder / "whole", periods), strict=False))
    missed, tried = [], 0
    with cut:
        for kind, topic in product(kinds, topics):
            print(f"{storage}: {kind} on {topic}", file=sys.stderr, flush=True)
            path = folder / f"{kind}-{topic}"
            record(path, storage, periods, spoil_of(kind, topic))
            said = playing_error(path, periods)
            tried += 1
            if f"({topic})" not in said:
                missed.append(f"{kind} on {topic}: {said or 'nothing was said'}")
    return same, missed, tried


def record(path: Path, storage: str, periods: int, spoil: Spoil | None) -> list[Reading]:
    """Drive on the bench and record its topics; return the readings of each period."""
    robot = load_robot("librarian")
    spec = spec_of()
    robot = robot.model_copy(update={"ros2": spec}).read_in(robot.folder)
    bench = LocalBench(robot, spec, KinematicBackend.build(robot, LIBRARY_FOLDER / "world.yaml", 0))
    found = []
    with (
        BagRecorder(path, bench.air, TOPICS, storage, spoil) as recorder,
        RosBackend(robot, bench) as backend,
    ):
        base, arm = backend.get(Base), backend.get(Arm)  # type: ignore[type-abstract]
        assert base is not None
        assert arm is not None
        recorder.record()
        begun = arm.joints()
        for period in range(periods):
            base.drive(0.2, 0.4)
            arm.move(begun + JOINT_STEP_RAD * (period + 1) * np.eye(len(begun))[0])
            backend.step()
            recorder.record()
            found.append(reading_of(backend))
    return found


def played(path: Path, periods: int) -> Iterator[Reading]:
    """Play a bag into a backend; yield the readings of each period."""
    with player(path) as backend:
        for _ in range(periods):
            backend.step()
            yield reading_of(backend)


def playing_error(path: Path, periods: int) -> str:
    """Return what a backend says about a bag; "" if it plays to its end."""
    try:
        for _ in played(path, periods):
            pass
    except (RobotFault, NotOnTheAir) as error:
        return str(error)
    return ""


def player(path: Path) -> RosBackend:
    """Return a backend before a bag."""
    robot = load_robot("librarian")
    robot = robot.model_copy(update={"ros2": spec_of()}).read_in(robot.folder)
    return RosBackend(robot, drivers=PlayedBag(BagLink(path), robot.period_s))


def spec_of() -> RosSpec:
    """Return the section `ros2` of the recorded robot."""
    return RosSpec(joint_states=RosTopicSpec(topic="joint_states", frame=""))


def reading_of(backend: RosBackend) -> Reading:
    """Return all readings of a period."""
    base, arm = backend.get(Base), backend.get(Arm)  # type: ignore[type-abstract]
    lidar, camera = backend.get(RangeSensor), backend.get(Camera)  # type: ignore[type-abstract]
    assert base is not None
    assert arm is not None
    assert lidar is not None
    assert camera is not None
    travel, ranges = base.wheel_travel(), lidar.scan().ranges
    joints = tuple(arm.joints().tolist())
    return Reading(travel.left, travel.right, joints, ranges.tobytes(), camera.image().tobytes())


def play_foreign(path: Path, name: str) -> int:
    """Print what differs between a bag and a robot's file; return 1 if anything does."""
    robot = load_robot(name)
    assert robot.ros2 is not None, "its file needs a section `ros2`"
    try:
        report = recorded_report(robot, robot.ros2, path, math.inf)
    except InputError as error:
        print(error)
        return 1
    for topic in report.topics:
        print(f"{topic.topic:<24}{topic.kind:<26}{topic.messages} messages, {topic.rate_hz:.1f} Hz")
    for finding in (*report.faults, *report.remarks):
        print(f"    {finding.words}")
    return 1 if report.faults else 0


def spoil_of(kind: str, topic: str) -> Spoil:
    """Return what spoils one topic of a bag from `SPOILED_S` on."""
    change = SPOILS[kind]

    def spoil(name: str, message: Any, now: float) -> Any:
        if name == topic and now >= SPOILED_S:
            change(message)
        return message

    return spoil


def _other_frame(message: Any) -> None:
    message.header.frame_id = "nowhere"


def _old_stamp(message: Any) -> None:
    message.header.stamp.sec -= 60


def _back(message: Any) -> None:
    message.header.stamp.sec, message.header.stamp.nanosec = 1, 400_000_000


def _not_finite(message: Any) -> None:
    if hasattr(message, "pose"):
        message.pose.pose.position.x = math.nan
    elif hasattr(message, "ranges"):
        message.angle_increment = math.nan
    else:
        message.position = np.full(len(message.position), math.nan)


SPOILS: dict[str, Callable[[Any], None]] = {
    "another frame": _other_frame,
    "old stamps": _old_stamp,
    "one stamp": _back,
    "NaN": _not_finite,
}

if __name__ == "__main__":
    main()
