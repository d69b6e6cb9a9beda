"""Measure how late the periods of a 20 Hz loop over ROS 2 end: `python -m benchmarks.ros2.lateness`.

A program drives in circles over the bench of another process, and reads odometry and lidar each period. The
same loop is measured without ROS, because the machine's own noise is in both. Of the periods that are too
long, the time in which the loop was ready to run but had no core is the machine's, the rest is the loop's
own (`benchmarks.ros2.judged`). Needs rclpy. Status 1 if the loop ended early, or if 99 % of its periods are
longer by more than 5 ms by its own share. Ctrl-C prints both rows until then; status 130.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping
from multiprocessing.connection import Connection
from typing import Any

from benchmarks.cut_off import CUT_OFF_STATUS, CutOff
from handcart.backends.live.pace import Pace

from .judged import LoopWatch
from .wire_rig import (
    DROVE_TO_END,
    FIRST_PERIODS,
    Ended,
    Process,
    cart,
    drive_circles,
    on_the_air,
    serve_bench,
)

WORK_LOOPS = 40_000
"""Additions a period in the loop without ROS: a few milliseconds."""
MAX_OWN_MS = 5.0
"""Limit of the lateness of 99 % of the periods, by the loop's own share."""
PATIENT_MS = 10_000.0
"""Age of readings that stops the program: on a busy machine the bench is late, and the loop is measured."""


def main() -> None:
    """Print both loops."""
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("--seconds", type=float, default=60.0, help="duration of each loop")
    seconds = words.parse_args().seconds
    if seconds < 2.0:
        words.error(
            f"--seconds is {seconds:g}; allowed: at least 2, the first {FIRST_PERIODS} periods do not count"
        )
    print(f"two loops of {seconds:g} s each ...", file=sys.stderr, flush=True)
    alone = Process(pace_alone, seconds)
    with CutOff() as cut:
        print("without ROS", alone.answer(10.0 * seconds + 60.0), flush=True)
    if cut.came:
        alone.pipe.send("end")
        print("without ROS", alone.answer(), "cut off", flush=True)
        sys.exit(CUT_OFF_STATUS)
    with on_the_air(0):
        bench, driver = Process(serve_bench), None
        with CutOff() as cut:
            bench.answer()
            driver = Process(drive_circles, seconds, 60.0, PATIENT_MS)
            said = driver.answer()
            ended = said if isinstance(said, Ended) else driver.answer(10.0 * seconds + 60.0)
        if cut.came and driver is not None:
            driver.pipe.send("end")
            ended = next(said for said in iter(driver.answer, None) if isinstance(said, Ended))
        for item in (driver, bench):
            if item is not None:
                item.kill()
    if cut.came and driver is None:
        sys.exit(CUT_OFF_STATUS)
    print("over ROS 2 ", ended.figures.get("loop"), ended.words, flush=True)
    print("    of periods too long:", ended.figures.get("too long"), flush=True)
    finding = finding_of(ended.words, ended.figures)
    if finding:
        print(f"    {finding}", flush=True)
    sys.exit(CUT_OFF_STATUS if cut.came else 1 if finding else 0)


def finding_of(words: str, figures: Mapping[str, Any]) -> str:
    """Return what is wrong with a loop; "" if nothing is.

    Args:
        words: how it ended.
        figures: its figures, with those of `LoopWatch` as "too long".
    """
    if words != DROVE_TO_END:
        return "the loop ended early; its figures are those of a part"
    own = figures.get("too long", {}).get("own_p99_ms")
    if own is None or own <= MAX_OWN_MS:
        return ""
    return f"99 % of the periods are up to {own:g} ms too long by the loop itself; allowed: {MAX_OWN_MS:g} ms"


def pace_alone(pipe: Connection, seconds: float) -> None:
    """Compute a little each period, and send how late the periods ended; any message ends it early."""
    robot = cart(1000.0)
    pace = Pace(robot.period_s, max_excess=1.0)
    pace.begin()
    watch = LoopWatch(robot.period_s)
    for _ in range(round(seconds / robot.period_s)):
        sum(range(WORK_LOOPS))
        pace.wait()
        watch.note()
        if pipe.poll():
            break
    pipe.send({**pace.figures(), **watch.figures()})


if __name__ == "__main__":
    main()
