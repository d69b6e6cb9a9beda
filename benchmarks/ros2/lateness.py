"""Measure how late the periods of a 20 Hz loop over ROS 2 end: `python -m benchmarks.ros2.lateness`.

A program drives in circles over the bench of another process, and reads odometry and lidar each period. The
same loop is measured without ROS, because the machine's own noise is in both. Of the periods that are too
long, the time in which the loop was ready to run but had no core is the machine's, the rest is the loop's
own (`benchmarks.ros2.judged`). Needs rclpy.
"""

from __future__ import annotations

import argparse
import sys
from multiprocessing.connection import Connection

from handcart.backends.live.pace import Pace

from .judged import LoopWatch
from .wire_rig import Process, cart, drive_circles, on_the_air, serve_bench

WORK_LOOPS = 40_000
"""Additions a period in the loop without ROS: a few milliseconds."""


def main() -> None:
    """Print both loops."""
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("--seconds", type=float, default=60.0, help="duration of each loop")
    asked = words.parse_args()
    print(f"two loops of {asked.seconds:g} s each ...", file=sys.stderr, flush=True)
    alone = Process(pace_alone, asked.seconds)
    print("without ROS", alone.answer(asked.seconds + 60.0), flush=True)
    with on_the_air(0):
        bench, driver = Process(serve_bench), None
        try:
            bench.answer()
            driver = Process(drive_circles, asked.seconds)
            driver.answer()
            ended = driver.answer(asked.seconds + 60.0)
            print("over ROS 2 ", ended.figures.get("loop"), ended.words, flush=True)
            print("    of periods too long:", ended.figures.get("too long"), flush=True)
        finally:
            for item in (driver, bench):
                if item is not None:
                    item.kill()


def pace_alone(pipe: Connection, seconds: float) -> None:
    """Compute a little each period, and send how late the periods ended."""
    robot = cart(1000.0)
    pace = Pace(robot.period_s, max_excess=1.0)
    pace.begin()
    watch = LoopWatch(robot.period_s)
    for _ in range(round(seconds / robot.period_s)):
        sum(range(WORK_LOOPS))
        pace.wait()
        watch.note()
    pipe.send({**pace.figures(), **watch.figures()})


if __name__ == "__main__":
    main()
