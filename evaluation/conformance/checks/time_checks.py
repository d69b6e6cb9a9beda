"""Checks of time: periods, clocks, seeds."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from unittest import mock

from handcart.backends.backend import Backend
from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.base import Base
from handcart.backends.capabilities.gripper import Gripper
from handcart.evaluation.conformance.rig.bench import KitBench
from handcart.evaluation.conformance.rig.parts import needed, part_of
from handcart.evaluation.conformance.rig.periods import (
    SETTLING_PERIODS,
    all_readings,
    beside,
    changing_readings,
    different_readings,
    drivable,
    steps,
)
from handcart.evaluation.judging.survey import simulated_world
from handcart.robotics.numerics.arrays import FloatArray

from .check import Check, CheckResult

Record = list[dict[str, FloatArray]]
SCRIPT_PERIODS = 40  # periods of the script
CLOCK_JUMP_S = 1e6  # [s] by which a clock is put forward at each look


def period(bench: KitBench, finding: CheckResult) -> None:
    """Check that a step lasts one period of the robot's file, by the distance driven in 40 steps."""
    spec = bench.spec()
    with bench.rig() as rig:
        backend, count, (speed, _) = rig.backend, 40, drivable(spec, 0.2, 0.0)
        finding.expect(backend.period == spec.period_s, f"{backend.period} s, not {spec.period_s} s")
        base = needed(backend, Base)
        for _ in range(20):  # until the speed is reached
            base.drive(speed, 0.0)
            backend.step()
        before = base.wheel_travel()
        for _ in range(count):
            base.drive(speed, 0.0)
            backend.step()
        far = base.wheel_travel().left - before.left
        seconds = far / speed
        finding.measured.append(f"{count} steps roll {far:.4g} m at {speed:g} m/s")
        finding.expect(
            abs(seconds / (count * spec.period_s) - 1.0) < 0.03, f"{count} steps last {seconds:.3g} s"
        )


def monotonic(bench: KitBench, finding: CheckResult) -> None:
    """Check that the simulated clock advances by one period with each step, not when sensors are read."""
    with bench.rig() as rig:
        scene = simulated_world(rig.backend)
        if scene is None:
            finding.skipped = "nothing is simulated"
            return
        for _ in range(10):
            before = scene.time
            all_readings(rig.backend)
            finding.expect(scene.time == before, "the clock advances while readings are taken")
            rig.backend.step()
            ahead = scene.time - before
            finding.expect(abs(ahead - rig.backend.period) < 1e-9, f"a step takes {ahead:g} s")


def same_seed(bench: KitBench, finding: CheckResult) -> None:
    """Check that the same seed gives the same readings, bit for bit, and another seed other readings."""
    first, second, other = (_script(bench, seed) for seed in (3, 3, 4))
    finding.wrong += [f"the same seed, another reading: {text}" for text in _different(first, second)]
    finding.measured.append(f"{len(first)} periods")
    if _different(first, other):
        return
    with bench.rig(3) as rig:
        noisy = changing_readings(rig.backend, SETTLING_PERIODS)
    finding.expect(not noisy, f"another seed gives the same readings, noise and all: {sorted(noisy)}")
    finding.measured.append("without noise: seeds make no difference")


def looking_on(bench: KitBench, finding: CheckResult) -> None:
    """Check that reading sensors more often than needed does not change a simulated run."""
    quiet = _script(bench, 3, look=lambda backend, number: number % 10 == 9)
    busy = _script(bench, 3)
    kept = [readings for number, readings in enumerate(busy) if number % 10 == 9]
    finding.wrong += [f"a reading that nobody needed changed {text}" for text in _different(quiet, kept)]


def wall_clock(bench: KitBench, finding: CheckResult) -> None:
    """Check that the readings do not depend on the wall clock."""
    if scene_of_bench(bench) is None:
        finding.skipped = "nothing is simulated"
        return
    plain = _script(bench, 3)
    with _other_clocks():
        hasty = _script(bench, 3)
    slow = _script(bench, 3, look=_dawdle)
    for words, record in (("with a clock that leaps", hasty), ("when steps take longer", slow)):
        finding.wrong += [f"{words}, {text} is another" for text in _different(plain, record)]


def _dawdle(backend: Backend, number: int) -> bool:
    """Delay the period by 10 ms of wall time; return True, so that the period is observed."""
    time.sleep(0.01)
    return True


def scene_of_bench(bench: KitBench) -> object:
    """Return the true state of the world that the tested backend simulates; None if it simulates none."""
    with bench.rig() as rig:
        scene: object = simulated_world(rig.backend)
        return scene


def _script(
    bench: KitBench, seed: int, look: Callable[[Backend, int], bool] = lambda backend, number: True
) -> Record:
    """Move base, arm and fingers together, and return the readings of the observed periods."""
    record: Record = []
    with bench.rig(seed) as rig:
        backend = rig.backend
        arm, gripper = part_of(backend, Arm), part_of(backend, Gripper)
        for number in range(SCRIPT_PERIODS):
            if number < SCRIPT_PERIODS // 2:
                needed(backend, Base).drive(*drivable(bench.spec(), 0.1, 0.2))
                if arm is not None:
                    arm.move(beside(bench.spec(), arm.command(), 0, 0.005))
                if gripper is not None:
                    gripper.move(0.5 * gripper.command())
            steps(backend, 1)
            if look(backend, number):
                record.append(all_readings(backend))
    return record


def _different(one: Record, other: Record) -> list[str]:
    """Return the names of readings that differ, with the first period in which they do."""
    first: dict[str, int] = {}
    for number, (a, b) in enumerate(zip(one, other, strict=True)):
        for name in sorted(different_readings(a, b)):
            first.setdefault(name, number)
    return [f"{name} from period {number} on" for name, number in first.items()]


@contextmanager
def _other_clocks() -> Iterator[None]:
    """Let Python's clocks jump by days each time they are read."""
    count = iter(range(10**9))

    def leap() -> float:
        return CLOCK_JUMP_S * next(count)

    names = ("time", "monotonic", "perf_counter", "process_time")
    patches = [mock.patch.object(time, name, leap) for name in names]
    for patch in patches:
        patch.start()
    try:
        yield
    finally:
        for patch in patches:
            patch.stop()


CHECKS = (
    Check("period", "a step is one period of the robot's file", period),
    Check("clock", "the simulated clock advances with each step, and only then", monotonic),
    Check("seed", "the same seed gives the same readings, bit for bit", same_seed),
    Check("looking on", "additional readings don't change the run", looking_on),
    Check("wall clock", "nothing depends on the wall clock", wall_clock),
)
