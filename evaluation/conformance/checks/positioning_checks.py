"""Checks of an indoor positioning system."""

from __future__ import annotations

import math

from handcart.backends.capabilities.base import Base
from handcart.backends.capabilities.positioning import PoseReading, Positioning
from handcart.evaluation.conformance.rig.bench import KitBench
from handcart.evaluation.conformance.rig.parts import needed
from handcart.evaluation.conformance.rig.periods import drivable
from handcart.evaluation.conformance.rig.skipped import Skipped
from handcart.evaluation.judging.survey import simulated_world

from .check import Check, CheckResult

DRIVE_PERIODS = 60
SPEED, TURN_RATE = 0.2, 0.3  # [m/s], [rad/s]
MAX_SIGMAS = 5.0


def positioning(bench: KitBench, finding: CheckResult) -> None:
    """Check that an external positioning system reports at its rate, and the true pose at the time stamp."""
    spec = bench.spec().positioning
    with bench.rig() as rig:
        backend, system, period = rig.backend, needed(rig.backend, Positioning), rig.backend.period
        scene = simulated_world(backend)
        if scene is None or spec is None:
            raise Skipped("no base's true place is known")
        poses, taken = [scene.base], list[tuple[float, PoseReading]]()
        for number in range(1, DRIVE_PERIODS + 1):
            if number <= DRIVE_PERIODS // 2:
                needed(backend, Base).drive(*drivable(bench.spec(), SPEED, TURN_RATE))
            backend.step()
            poses.append(scene.base)
            reading = system.reading()
            if reading is not None and (not taken or reading.number != taken[-1][1].number):
                taken.append((number * period, reading))
        finding.expect(len(taken) > 1, "no readings come")
        true = [poses[max(0, round((time - item.age) / period))] for time, item in taken]
        off = [item.pose.distance(pose) for (_, item), pose in zip(taken, true, strict=True)]
        turned = [item.pose.turn(pose) for (_, item), pose in zip(taken, true, strict=True)]
        finding.at_most(
            "off", 1e3 * max(off, default=0.0), MAX_SIGMAS * math.sqrt(2.0) * spec.sigma_mm + 1.0, "mm"
        )
        most = MAX_SIGMAS * spec.heading_sigma_mrad + 1.0
        finding.at_most("turned", 1e3 * max(turned, default=0.0), most, "mrad")
        oldest = spec.latency_s + 2.0 * period
        finding.at_most("age", max((item.age for _, item in taken), default=0.0), oldest, "s")
        wanted = min(spec.rate_hz, 1.0 / period) * DRIVE_PERIODS * period
        finding.expect(
            abs(len(taken) - wanted) <= 0.1 * wanted + 2.0, f"{len(taken)} readings, not {wanted:.0f}"
        )


CHECKS = (
    Check("positioning", "readings come at their rate, and match the base's pose at their time", positioning),
)
