"""Checks of radio beacons."""

from __future__ import annotations

import math

import numpy as np

from handcart.backends.capabilities.base import Base
from handcart.backends.capabilities.beacons import Beacons
from handcart.evaluation.conformance.rig.bench import KitBench
from handcart.evaluation.conformance.rig.parts import needed
from handcart.evaluation.conformance.rig.periods import drivable
from handcart.evaluation.conformance.rig.skipped import Skipped
from handcart.evaluation.judging.survey import simulated_world

from .check import Check, CheckResult

READING_COUNT = 30
DRIVE_SPEED_M_S = 0.2  # [m/s]
MAX_SIGMAS = 5.0


def beacons(bench: KitBench, finding: CheckResult) -> None:
    """Check that ranges to radio beacons arrive at the rate of the robot's file and match true distances."""
    with bench.rig() as rig:
        backend, radio, spec = rig.backend, needed(rig.backend, Beacons), bench.spec().beacons
        scene = simulated_world(backend)
        if scene is None or spec is None:
            raise Skipped("no beacon's true place is known")
        base, tag = needed(backend, Base), np.array([*spec.tag_m, 1.0])
        places, off = np.array(list(spec.places_m.values())), list[np.ndarray]()
        periods = math.ceil(READING_COUNT * spec.period_s / backend.period)
        for number in range(periods):
            if number < periods // 2:
                base.drive(*drivable(bench.spec(), DRIVE_SPEED_M_S, 0.0))
            backend.step()
            heard = radio.ranges()
            if heard is not None:
                finding.expect(heard.distances.shape == (len(places),), f"ranges {heard.distances.shape}")
                true = np.linalg.norm(places - (scene.world_T_base @ tag)[:3], axis=1)
                off.append(np.abs(heard.distances - true)[true < spec.reach_m])
        finding.expect(abs(len(off) - READING_COUNT) <= 1, f"{len(off)} times, not {READING_COUNT}")
        most = (
            MAX_SIGMAS * math.hypot(spec.sigma_m, spec.bias_m, spec.scale_percent / 100 * spec.reach_m) + 1e-3
        )
        finding.at_most("off", float(np.concatenate(off).max(initial=0.0)) if off else math.inf, most, "m")


CHECKS = (Check("beacons", "ranges come at their rate, and match the distances of the beacons", beacons),)
