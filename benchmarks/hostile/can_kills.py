"""Kill a program, and check that no drive keeps turning: `python -m benchmarks.hostile.can_kills --kills
100`.

`handcart bench` runs as a process of its own, on python-can's `udp_multicast`. A second process drives the
cart by CAN and is killed (SIGKILL) at a random moment. From then on the drives have the heartbeat time and
their ramp to come to rest; then they must stay at rest.
"""

from __future__ import annotations

import json
import multiprocessing
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from multiprocessing.synchronize import Event
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from handcart.backends.backend import RobotFault
from handcart.backends.can.can_backend import CanBackend
from handcart.backends.capabilities.base import Base
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.loading.robot_loading import load_robot

ROBOT_NAME = "cart"
MULTICAST_CHANNEL = "239.74.163.77"
SPEED_M_S = 0.5  # [m/s]
# [s]: drives look each 5 ms, time passes on the bench in steps of 5 ms, and is then written down
WATCH_STEP_S = 0.02
QUIET_TIME_S = 0.5  # [s] that the drives are watched afterwards


@dataclass(frozen=True)
class Kill:
    """One of them."""

    speed: float
    """Speed commanded to the faster wheel [m/s]: a drive keeps accelerating until it misses the heartbeat."""
    stood_after: float
    """Time until no drive turned any more [s]; infinite if one never stopped, or moved again."""
    distance: float
    """Distance that the faster wheel rolled after the kill [m]."""
    allowed: float
    """[s]: heartbeat time, ramp, and 20 ms to be seen."""

    @property
    def held(self) -> bool:
        """True if the drives stopped within the allowed time."""
        return self.stood_after <= self.allowed


def reachable(robot: RobotFile) -> RobotFile:
    """Return the robot with its drives on the bench's bus."""
    assert robot.can is not None
    spec = robot.can.model_copy(update={"interface": "udp_multicast", "channel": MULTICAST_CHANNEL})
    return robot.model_copy(update={"can": spec})


def motion(seed: int) -> tuple[float, float]:
    """Return the commanded speed [m/s] and turn rate [rad/s]."""
    rng = random.Random(f"motion {seed}")
    return rng.choice((-1, 1)) * rng.uniform(0.3, SPEED_M_S), rng.uniform(-0.3, 0.3)


def drive_until_killed(moving: Event, seed: int) -> None:
    """Drive to and fro until the process is killed."""
    robot = reachable(load_robot(ROBOT_NAME))
    backend = CanBackend.build(robot, None, 0)
    base = backend.get(Base)  # type: ignore[type-abstract]
    assert base is not None
    rng, (speed, turn) = random.Random(seed), motion(seed)
    ramp = SPEED_M_S / robot.drive.acceleration_m_s2
    for period in range(10_000):
        base.drive(speed, turn)
        try:
            backend.step()
        except RobotFault:
            return
        if period * backend.period > rng.uniform(0.3, 1.0) * ramp:
            moving.set()


@contextmanager
def bench(log: Path) -> Iterator[None]:
    """Run the drives as a process of their own."""
    words = [ROBOT_NAME, "--channel", MULTICAST_CHANNEL, "--log", str(log)]
    with subprocess.Popen(
        [sys.executable, "-m", "handcart", "bench", *words], stdout=subprocess.PIPE
    ) as made:
        assert made.stdout is not None
        made.stdout.readline()
        try:
            yield
        finally:
            made.send_signal(signal.SIGINT)
            made.wait(10.0)


def rows(log: Path, since: float) -> list[tuple[float, list[float], list[float]]]:
    """Read the bench's rows: monotonic time [s], positions and velocities in counts."""
    read = []
    with log.open("rb") as file:
        file.seek(max(0, log.stat().st_size - 100_000))
        lines = file.read().decode().split("\n")[1:-1]
    for line in lines:
        stamp, _, *drives = line.split(",")
        if float(stamp) >= since:
            fields = [drive.split(":") for drive in drives]
            read.append(
                (float(stamp), [float(field[1]) for field in fields], [float(field[2]) for field in fields])
            )
    return read


def kill_once(log: Path, seed: int, robot: RobotFile) -> Kill | None:
    """Start the program, kill it while it drives, look at the drives; None where it didn't come to that."""
    assert robot.can is not None
    context = multiprocessing.get_context("fork")
    moving = context.Event()
    process = context.Process(target=drive_until_killed, args=(moving, seed), daemon=True)
    process.start()
    while not moving.wait(0.1):
        if not process.is_alive():
            return None  # it stopped by itself: this machine let it wait for too long
    time.sleep(random.Random(seed).uniform(0.0, 0.2))
    assert process.pid is not None
    os.kill(process.pid, signal.SIGKILL)
    killed = time.monotonic()
    process.join()
    counts = abs(robot.can.left.counts_per_m(robot.drive.wheel_radius_m))
    _, begun, _ = rows(log, killed - 3 * robot.period_s)[-1]
    speed, turn = motion(seed)
    rim = abs(speed) + abs(turn) * robot.drive.tread_m / 2
    time.sleep(1.0 + QUIET_TIME_S)
    after = rows(log, killed)
    moved = [stamp for stamp, _, speeds in after if max(map(abs, speeds)) > 0.0]
    last = moved[-1] if moved else killed
    first_still = next((stamp for stamp, _, _ in after if stamp > last), float("inf"))
    rolled = max(abs(end - start) for end, start in zip(after[-1][1], begun, strict=True)) / counts
    return Kill(rim, first_still - killed, rolled, allowed(robot, rim))


def allowed(robot: RobotFile, speed: float) -> float:
    """[s] from the kill to standing still: heartbeat time, ramp, and 20 ms until the log shows it."""
    from handcart.backends.can.drives.axes import Axes

    assert robot.can is not None
    left = Axes(robot, robot.can).left
    return robot.can.heartbeat_timeout_ms / 1e3 + speed / left.limits.braking + WATCH_STEP_S


def run(kills: int, tell: Callable[[str], None], seed: int = 0) -> list[Kill]:
    """Kill so often."""
    robot = reachable(load_robot(ROBOT_NAME))
    results: list[Kill] = []
    with tempfile.TemporaryDirectory() as folder:
        log = Path(folder) / "bench.csv"
        with bench(log):
            while len(results) < kills:
                one, seed = kill_once(log, seed, robot), seed + 1
                if one is None:
                    tell("      stopped by itself before it was killed; another")
                    continue
                results.append(one)
                tell(
                    f"{len(results):4d}  {one.speed:.2f} m/s  at rest after {1e3 * one.stood_after:4.0f} ms, "
                    f"allowed {1e3 * one.allowed:4.0f} ms  rolled {1e3 * one.distance:4.0f} mm  "
                    f"{'' if one.held else '<- too late'}"
                )
    return results


def figures(results: list[Kill]) -> dict[str, float | int]:
    """Return the figures that are reported."""
    stood = np.array([result.stood_after for result in results])
    margin = np.array([result.allowed - result.stood_after for result in results])
    return {
        "kills": len(results),
        "too_late": sum(not result.held for result in results),
        "stood_p50_ms": round(1e3 * float(np.percentile(stood, 50)), 1),
        "stood_p99_ms": round(1e3 * float(np.percentile(stood, 99)), 1),
        "stood_max_ms": round(1e3 * float(stood.max()), 1),
        "beyond_heartbeat_and_ramp_max_ms": round(1e3 * (WATCH_STEP_S - float(margin.min())), 1),
        "distance_max_mm": round(1e3 * max(result.distance for result in results), 1),
    }


def main(
    kills: Annotated[int, typer.Option(help="how often")] = 100,
    seed: Annotated[int, typer.Option(help="of the moments")] = 0,
    fifo: Annotated[
        bool, typer.Option("--fifo", help="SCHED_FIFO, where allowed: nobody else counts")
    ] = False,
    as_json: Annotated[bool, typer.Option("--json", help="one JSON object on stdout")] = False,
) -> None:
    """Kill, watch, and report; status 1 if a drive stopped too late."""
    if fifo:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(20))
    results = run(kills, lambda words: print(words, file=sys.stderr, flush=True), seed)
    found = figures(results)
    if as_json:
        print(json.dumps({**found, "trials": [asdict(result) for result in results]}))
    else:
        for name, value in found.items():
            print(f"{name:<34} {value}")
    sys.exit(1 if found["too_late"] else 0)


if __name__ == "__main__":
    typer.run(main)
