"""Measure the delay of a stop and the cost of the loop: `python -m benchmarks.can [--faults N] [--json]`.

Both on python-can's `virtual`, by the wall clock. Stop: the librarian's nine drives are served in a thread
of their own; at a random instant one of them misbehaves, and the time counts from the frame that shows it
to the last quick stop that is sent. Loop: eight drives at 100 Hz and 1 Mbit/s, simulated in the same
thread, so the cost of the drives is included.
"""

from __future__ import annotations

import argparse
import json
import random
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import can
import numpy as np
from can.interfaces.virtual import VirtualBus
from typing_extensions import override

from handcart.backends.can.bench.bench import Bench
from handcart.backends.can.bench.injected_faults import injected_fault
from handcart.backends.can.bus.errors import CanFault
from handcart.backends.can.can_backend import CanBackend
from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.base import Base
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.live.pace import Pace
from handcart.backends.loading.robot_loading import load_robot

BUS_FAULTS = ("emergency", "collision", "two-nodes", "stranger", "stranger-command", "reboot")
"""Faults that a single frame shows."""
PERIOD_S = 0.05
LOOP_PERIOD, LOOP_S = 0.01, 20.0
ALLOWED_MS = 10.0
"""Delay beyond one period that 99 of 100 stops have to keep [ms]."""
ALLOWED_PERCENT = 40.0
QUICK_STOP = 0x02


class Patient(Pace):
    """Counts what is late, and doesn't stop for it: machines that are measured on may be busy."""

    @override
    def wait(self) -> None:
        super().wait()
        self.trouble = ""


def on_bus(channel: str, period: float) -> RobotFile:
    """Return the librarian with its drives on a virtual bus of that name."""
    robot = load_robot("librarian")
    assert robot.can is not None
    spec = robot.can.model_copy(update={"interface": "virtual", "channel": channel})
    return robot.model_copy(update={"can": spec, "period_s": period})


@contextmanager
def served(robot: RobotFile) -> Iterator[tuple[Bench, threading.Lock]]:
    """Yield simulated drives that answer by themselves, and a lock that makes them wait."""
    assert robot.can is not None
    bench = Bench(robot, robot.can, None, VirtualBus(robot.can.channel))
    end, lock = threading.Event(), threading.Lock()

    def serve() -> None:
        while not end.is_set():
            with lock:
                bench.serve()
            time.sleep(0.0005)

    thread = threading.Thread(target=serve)
    thread.start()
    try:
        yield bench, lock
    finally:
        end.set()
        thread.join()
        bench.close()


def stop_after(fault: str, wait_s: float, number: int) -> float:
    """Return the time from a fault to the last quick stop that is sent [ms]."""
    robot = on_bus(f"stops {number}", PERIOD_S)
    stops: list[float] = []

    def sent(frame: can.Message, ours: bool) -> None:
        if ours and 0x200 < frame.arbitration_id < 0x280 and frame.data[0] == QUICK_STOP:
            stops.append(time.perf_counter())

    with served(robot) as (bench, lock):
        backend = CanBackend(robot, None)
        backend._pace = Patient(PERIOD_S, sleep=backend._listen)
        backend._line.listen(sent)
        shown: list[float] = []

        def show() -> None:
            time.sleep(wait_s)
            with lock:
                bench.go_wrong(injected_fault(fault).act)
                shown.append(time.perf_counter())

        going_wrong = threading.Thread(target=show)
        backend.step()
        going_wrong.start()
        try:
            while True:
                backend.get(Base).drive(0.3, 0.0)  # type: ignore[type-abstract, union-attr]
                backend.step()
        except CanFault:
            going_wrong.join()
        first = sorted(stops)[: len(backend.axes)]
        backend.close()
    return 1e3 * (first[-1] - shown[0])


def loop_cost() -> dict[str, float]:
    """Return the CPU use of the loop at 100 Hz [% of one core] and its lateness [ms]."""
    robot = on_bus("loop", LOOP_PERIOD)
    assert robot.can is not None
    robot = robot.model_copy(
        update={"can": robot.can.model_copy(update={"gripper": None, "bitrate_kbit_s": 1000})}
    )
    backend = CanBackend(robot, Bench(robot, robot.can, None))  # type: ignore[arg-type]
    backend._pace = pace = Patient(LOOP_PERIOD)
    base, arm = backend.get(Base), backend.get(Arm)  # type: ignore[type-abstract]
    assert base is not None
    assert arm is not None
    backend.step()
    posture, drives = arm.command(), len(backend.axes)
    began, spent = time.perf_counter(), time.process_time()
    for number in range(round(LOOP_S / LOOP_PERIOD)):
        base.drive(0.3 * np.sin(0.01 * number), 0.2)
        arm.move(posture + 0.05 * (1.0 - np.cos(0.02 * number)) * np.ones(len(posture)))
        backend.step()
    wall, cpu = time.perf_counter() - began, time.process_time() - spent
    figures = pace.figures()
    backend.close()
    load = {"drives": drives, "cpu_percent": round(100.0 * cpu / wall, 1), "periods": figures["periods"]}
    return load | {name: figures[name] for name in ("missed", "late_p50_ms", "late_p99_ms", "late_max_ms")}


def stops(count: int, say: Callable[[str], None]) -> dict[str, float]:
    """Percentiles over so many faults, in [ms]."""
    drawn = random.Random(0)
    delays = []
    for number in range(count):
        fault = BUS_FAULTS[number % len(BUS_FAULTS)]
        delays.append(stop_after(fault, drawn.uniform(0.1, 0.1 + PERIOD_S), number))
        if number % 20 == 19:
            say(f"{number + 1} faults")
    p50, p99 = np.percentile(delays, (50, 99))
    return {
        "faults": count,
        "period_ms": 1e3 * PERIOD_S,
        "p50_ms": round(float(p50), 2),
        "p99_ms": round(float(p99), 2),
        "max_ms": round(max(delays), 2),
    }


def main() -> None:
    """Print both."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--faults", type=int, default=100, help="how many are injected")
    parser.add_argument("--json", action="store_true", help="end with one JSON object")
    given = parser.parse_args()
    stopping = stops(given.faults, (lambda _: None) if given.json else print)
    cost = loop_cost()
    within = stopping["p99_ms"] <= stopping["period_ms"] + ALLOWED_MS
    cheap = cost["cpu_percent"] <= ALLOWED_PERCENT
    if given.json:
        print(json.dumps({"stop": stopping | {"holds": within}, "loop": cost | {"holds": cheap}}))
        return
    p50, p99, most = (stopping[name] for name in ("p50_ms", "p99_ms", "max_ms"))
    latency = f"a stop has left {p50} ms (p50), {p99} ms (p99), {most} ms (max) after the fault shows"
    ends = "holds" if within else "does not hold"
    print(f"{latency}; {given.faults} faults, period {1e3 * PERIOD_S:g} ms: {ends}")
    print(f"{cost['drives']} drives at 100 Hz: {cost['cpu_percent']} % of one core, {cost}")


if __name__ == "__main__":
    main()
