"""Checks of a satellite receiver."""

from __future__ import annotations

import math

import numpy as np

from handcart.backends.capabilities.base import Base
from handcart.backends.capabilities.gps import Gps
from handcart.evaluation.conformance.rig.bench import KitBench
from handcart.evaluation.conformance.rig.parts import needed
from handcart.evaluation.conformance.rig.periods import drivable
from handcart.evaluation.conformance.rig.skipped import Skipped
from handcart.evaluation.judging.survey import simulated_world

from .check import Check, CheckResult

FIX_COUNT = 30
DRIVE_SPEED_M_S = 0.2  # [m/s]
# sigmas that the median of fixes may be off, of two axes; outliers and reflections come beside
MAX_MEDIAN_SIGMAS = 3.0


def gps(bench: KitBench, finding: CheckResult) -> None:
    """Check that fixes come at their rate and match the true position of the antenna, in [m]."""
    robot = bench.spec()
    with bench.rig() as rig:
        backend, receiver = rig.backend, needed(rig.backend, Gps)
        scene, spec = simulated_world(backend), robot.gps
        if scene is None or spec is None:
            raise Skipped("no antenna's true place is known")
        base, antenna, off = needed(backend, Base), np.array([*robot.antenna, 1.0]), list[float]()
        periods = math.ceil(FIX_COUNT * spec.period_s / backend.period)
        for number in range(periods):
            if number < periods // 2:
                base.drive(*drivable(robot, DRIVE_SPEED_M_S, 0.0))
            backend.step()
            fix = receiver.fix()
            if fix is not None:
                finding.expect(fix.position.shape == (2,), f"a position {fix.position.shape}")
                off.append(math.dist(fix.position, (scene.world_T_base @ antenna)[:2]))
        finding.expect(abs(len(off) - FIX_COUNT) <= 1, f"{len(off)} fixes, not {FIX_COUNT}")
        most = MAX_MEDIAN_SIGMAS * math.hypot(spec.white_m, spec.drift_m) + 1e-3
        finding.at_most("off, median", float(np.median(off)) if off else math.inf, most, "m")


CHECKS = (Check("gps", "fixes come at their rate, and match the position of the antenna", gps),)
