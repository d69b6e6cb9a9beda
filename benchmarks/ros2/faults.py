"""Spoil topics while a program drives by them, through the middleware: `python -m benchmarks.ros2.faults`.

Each trial has a bench and a program in processes of their own. The program drives in circles; then a topic
is spoiled, a second node takes the command, or the bench appears late. Counted is whether the program noticed
it and named the topic, how long that took, and when the base rested. Doubled and swapped messages are noticed
by their count, and the program goes on. A trial in which the machine was too slow for its loops is not judged
(`benchmarks.ros2.judged`). Needs rclpy. Status 1 if anything was missed, or no trial of a row is judged.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable
from multiprocessing.connection import Connection
from typing import NamedTuple

import numpy as np

from benchmarks.cut_off import CUT_OFF_STATUS, CutOff
from handcart.backends.ros2.bench.bench_faults import ACTION_KINDS, FAULT_KINDS, TopicFault
from handcart.backends.ros2.bench.ros_bench import COMMAND_TIMEOUT_S
from handcart.backends.ros2.wire.ros_link import RosLink

from .judged import Lateness, Tally, Verdict
from .wire_rig import (
    Ended,
    Process,
    Rest,
    await_driving,
    drive_circles,
    on_the_air,
    serve_bench,
    warm_up,
    watching,
)

GOES_ON = ("doubled", "swapped")
OTHER_FAULTS = ("second master", "wrong type", "late bench")
LATE_S, DISCOVERY_S = 3.0, 5.0
MAX_PERIODS = 7
"""Periods of the bench in which the base may move after the report: its time-out, and two."""
REST_TIMEOUT_S = COMMAND_TIMEOUT_S + 0.1
"""[s] after the report in which the base has to rest: its own time-out, and two periods."""


class Noticed(NamedTuple):
    """Result of a trial."""

    wrong: str
    """Why it counts as missed; "" if it doesn't."""
    after_s: float = 0.0
    """Time from the fault to the report."""
    rest_s: float = 0.0
    """Time from the report until the base is at rest."""
    late: Lateness = Lateness()
    """Time by which a period of bench or program was too long, at most."""


def main() -> None:
    """Print a row for each fault."""
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("--count", type=int, default=20, help="trials of each fault")
    words.add_argument("--topics", nargs="+", default=["odom", "scan"])
    kinds = [*(kind for kind in FAULT_KINDS if kind not in ACTION_KINDS), *OTHER_FAULTS]
    words.add_argument("--kinds", nargs="+", choices=kinds, default=kinds, metavar="KIND")
    asked = words.parse_args()
    missed, trial = 0, 0
    warm_up()
    for kind in asked.kinds:
        for topic in (
            ("cmd_vel",) if kind == OTHER_FAULTS[0] else ("odom",) if kind in OTHER_FAULTS else asked.topics
        ):
            found: list[Noticed] = []
            with CutOff() as cut:
                for _ in range(asked.count):
                    done = f"\r{kind} on {topic}: {len(found)} of {asked.count}"
                    print(done, end="", file=sys.stderr, flush=True)
                    with on_the_air(trial), watching() as watched:
                        noticed = FAULT_TRIALS.get(kind, spoiled)(kind, topic)
                    found.append(noticed._replace(late=watched.late))
                    trial += 1
            print(file=sys.stderr)
            if not found:
                sys.exit(CUT_OFF_STATUS)
            tally = Tally([Verdict(noticed.wrong, noticed.late) for noticed in found])
            missed += tally.missed
            after, rest = (
                np.max([getattr(noticed, name) for noticed in found]) for name in ("after_s", "rest_s")
            )
            print(
                f"{kind:<14}{topic:<9}noticed {tally.words}"
                f"  at most {after:.2f} s after, at rest {rest:.2f} s later"
                f"{cut.words(len(found), asked.count)}",
                flush=True,
            )
            for item in tally.findings():
                print(f"    {item}", flush=True)
            if cut.came:
                sys.exit(CUT_OFF_STATUS)
    sys.exit(1 if missed else 0)


def spoiled(kind: str, topic: str) -> Noticed:
    """Spoil a topic under way."""
    bench, driver = Process(serve_bench), None
    try:
        bench.answer()
        driver = Process(drive_circles, 4.0 if kind in GOES_ON else 30.0)
        await_driving(driver)
        bench.pipe.send(TopicFault(kind, topic, 0.0))
        return _judged(kind, topic, bench, driver, time.monotonic())
    except TimeoutError as error:
        return Noticed(str(error))
    finally:
        for item in (driver, bench):
            if item is not None:
                item.kill()


def mastered(kind: str, topic: str) -> Noticed:
    """Let a second node publish speeds under way."""
    bench = Process(serve_bench)
    bench.answer()
    driver = Process(drive_circles, 30.0)
    await_driving(driver)
    begun = time.monotonic()
    other = Process(_rival, "Twist", topic)
    try:
        return _judged(kind, topic, bench, driver, begun)
    except TimeoutError as error:
        return Noticed(str(error))
    finally:
        for item in (driver, bench, other):
            item.kill()


def mistyped(kind: str, topic: str) -> Noticed:
    """Publish a topic with another type, and no bench."""
    begun = time.monotonic()
    other, driver = Process(_rival, "Pose2D", topic), Process(drive_circles, 4.0, DISCOVERY_S)
    try:
        ended = driver.answer()
        named = f"({topic})" in ended.words and "its type is not" in ended.words
        return Noticed("" if named else ended.words, ended.time - begun)
    except TimeoutError as error:
        return Noticed(str(error))
    finally:
        for item in (driver, other):
            item.kill()


def discovered_late(kind: str, topic: str) -> Noticed:
    """Start the bench long after the program."""
    driver = Process(drive_circles, 2.0)
    time.sleep(LATE_S)
    bench, begun = Process(serve_bench), time.monotonic()
    try:
        said = driver.answer()
        after = time.monotonic() - begun
        return Noticed("" if said == "drives" else str(said), after)
    except TimeoutError as error:
        return Noticed(str(error))
    finally:
        for item in (driver, bench):
            item.kill()


def _judged(kind: str, topic: str, bench: Process, driver: Process, begun: float) -> Noticed:
    ended: Ended = driver.answer()
    if kind in GOES_ON:
        counted = topic in ended.figures.get("rejected_messages", {})
        good = counted and ended.words == "drove to its end"
        return Noticed("" if good else f"{ended.words}; {ended.figures}")
    time.sleep(REST_TIMEOUT_S + 0.2)
    bench.pipe.send(ended.time)
    rest: Rest = bench.answer()
    wrong = "" if topic in ended.words else f"not named: {ended.words}"
    wrong = wrong or ("" if rest.periods <= MAX_PERIODS else f"moved {rest.periods} periods after the report")
    return Noticed(wrong, ended.time - begun, rest.seconds)


def _rival(pipe: Connection, kind: str, topic: str) -> None:
    """Publish messages of some type, ten times a second."""
    link = RosLink("rival")
    kind = f"geometry_msgs/{kind}"
    publish = link.publisher(kind, topic)
    while True:
        publish(link.message(kind))
        time.sleep(0.1)


FAULT_TRIALS: dict[str, Callable[[str, str], Noticed]] = dict(
    zip(OTHER_FAULTS, (mastered, mistyped, discovered_late), strict=True)
)

if __name__ == "__main__":
    main()
