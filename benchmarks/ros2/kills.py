"""Kill program or bench while the base drives, through the middleware: `python -m benchmarks.ros2.kills`.

The program is killed (SIGKILL) at a random instant: the base has to rest within its own time-out. The bench
is killed: the program has to end with a fault that names a topic. A trial in which the machine was too slow
for its loops is not judged (`benchmarks.ros2.judged`). Needs rclpy. Status 1 if either failed.
"""

from __future__ import annotations

import argparse
import random
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

from benchmarks.cut_off import CUT_OFF_STATUS, CutOff
from handcart.backends.ros2.bench.ros_bench import COMMAND_TIMEOUT_S

from .judged import Tally, Verdict
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

PERIODS_S = 0.1
"""[s] of two periods, beyond the base's time-out."""
MAX_PERIODS = round((COMMAND_TIMEOUT_S + PERIODS_S) / 0.05)
"""Periods of the bench in which the base may still move: a busy machine stretches seconds, not these."""
REPORT_TIMEOUT_S = 1.5


def main() -> None:
    """Print both rows."""
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("--count", type=int, default=20, help="kills of each of both")
    words.add_argument("--which", nargs="+", default=["program", "bench"], help="what is killed")
    words.add_argument("--seed", type=int, default=0, help="of the instants")
    asked = words.parse_args()
    rng = random.Random(asked.seed)
    failed, most_periods = 0, 0
    warm_up()
    for name, kill in (("program", kill_program), ("bench", kill_bench)):
        if name not in asked.which:
            continue
        times, verdicts = [], []
        with CutOff() as cut:
            for trial in range(asked.count):
                print(f"\r{name} killed: {trial} of {asked.count}", end="", file=sys.stderr, flush=True)
                with on_the_air(trial), watching() as watched:
                    seconds, periods, finding = kill(rng.uniform(0.0, 0.5))
                times.append(seconds)
                most_periods = max(most_periods, periods)
                verdicts.append(Verdict(finding, watched.late))
        print(file=sys.stderr)
        if not verdicts:
            sys.exit(CUT_OFF_STATUS)
        what = "base at rest" if name == "program" else "reported with a topic"
        middle, most = np.percentile(times, 50.0), np.max(times)
        tally = Tally(verdicts)
        counts = f"{what} {tally.words}"
        print(
            f"{name} killed {len(times)} times: {counts}, median {middle:.2f} s, at most {most:.2f} s"
            f"{cut.words(len(times), asked.count)}",
            flush=True,
        )
        if name == "program":
            print(
                f"    the base moved for at most {most_periods} periods of the bench afterwards", flush=True
            )
        for item in tally.findings():
            print(f"    {item}", flush=True)
        failed += tally.missed
        if cut.came:
            sys.exit(CUT_OFF_STATUS)
    sys.exit(1 if failed else 0)


@contextmanager
def driving_pair(after_s: float) -> Iterator[tuple[Process, Process]]:
    """Yield a bench and a program that has driven it for `after_s` seconds; both are killed in the end."""
    bench = Process(serve_bench)
    driver = None
    try:
        bench.answer()
        driver = Process(drive_circles, 60.0)
        await_driving(driver)
        time.sleep(after_s)
        yield bench, driver
    finally:
        for item in (driver, bench):
            if item is not None:
                item.kill()


def kill_program(after_s: float) -> tuple[float, int, str]:
    """Kill the program; return the time until the base rests in [s] and in periods, and what is wrong."""
    try:
        with driving_pair(after_s) as (bench, driver):
            killed = driver.kill()
            time.sleep(COMMAND_TIMEOUT_S + 5.0 * PERIODS_S)
            bench.pipe.send(killed)
            rest: Rest = bench.answer()
    except TimeoutError as error:
        return 0.0, 0, str(error)
    wrong = "" if rest.periods <= MAX_PERIODS else f"the base drove for {rest.periods} periods"
    return rest.seconds, rest.periods, wrong


def kill_bench(after_s: float) -> tuple[float, int, str]:
    """Kill the bench; return the time until the program reports it in [s], 0, and what is wrong."""
    try:
        with driving_pair(after_s) as (bench, driver):
            killed = bench.kill()
            ended: Ended = driver.answer(20.0)
    except TimeoutError as error:
        return 0.0, 0, str(error)
    after = ended.time - killed
    if not any(topic in ended.words for topic in ("(odom)", "(scan)")):  # whichever is read first
        return after, 0, f"not named: {ended.words}"
    return after, 0, "" if after <= REPORT_TIMEOUT_S else f"reported after {after:.2f} s"


if __name__ == "__main__":
    main()
