"""Checks of an inertial measurement unit."""

from __future__ import annotations

import math

import numpy as np

from handcart.backends.capabilities.base import Base
from handcart.backends.capabilities.imu import Imu
from handcart.evaluation.conformance.rig.bench import KitBench
from handcart.evaluation.conformance.rig.parts import needed
from handcart.evaluation.conformance.rig.periods import SETTLING_PERIODS, STEERING_PERIODS, drivable, steps

from .check import Check, CheckResult

GRAVITY_M_S2 = 9.81  # [m/s²]
REST_PERIODS = 40  # periods that are averaged
MAX_SIGMAS = 5.0
# [m/s²] along x and y of a robot that is not quite level
MAX_LEANING_GRAVITY_M_S2 = 0.02 * GRAVITY_M_S2
TURN_RATE, PERIODS = 0.4, 30  # [rad/s]


def imu(bench: KitBench, finding: CheckResult) -> None:
    """Check that the IMU reads +9.81 m/s² along z at rest, and positive rates about z when turning left."""
    spec = bench.spec().imu
    with bench.rig() as rig:
        unit, backend = needed(rig.backend, Imu), rig.backend
        assert spec is not None, "the check of capabilities tells that"
        felt, turned = [], []
        for _ in range(REST_PERIODS):
            steps(backend, 1)
            felt.append(unit.accelerations())
            turned.append(unit.rates())
        finding.expect(felt[0].shape == turned[0].shape == (3,), "a reading isn't (3,)")
        off = np.abs(np.mean(felt, axis=0) - [0.0, 0.0, GRAVITY_M_S2])
        allowed = (
            MAX_SIGMAS * (spec.accelerometer_sigma_m_s2 + spec.accelerometer_bias_m_s2)
            + MAX_LEANING_GRAVITY_M_S2
        )
        finding.at_most("gravity at rest, off", float(off.max()), allowed, "m/s²")
        noise = spec.angle_random_walk_deg_rt_s / math.sqrt(REST_PERIODS * backend.period)
        bias = math.radians(MAX_SIGMAS * (noise + spec.gyro_bias_deg_s + spec.warm_up_deg_s))
        rest = np.mean(turned, axis=0)
        finding.at_most("turn rates at rest", float(np.abs(rest).max()), bias + 1e-4, "rad/s")
        _turns(bench, finding, float(rest[2]))


def _turns(bench: KitBench, finding: CheckResult, bias: float) -> None:
    """Check the gyro about z while turning both ways; `bias` is its reading at rest, in [rad/s]."""
    with bench.rig() as rig:
        unit, base, backend = needed(rig.backend, Imu), needed(rig.backend, Base), rig.backend
        for way, sign in (("left", 1.0), ("right", -1.0)):
            turn, car = 0.0, bench.spec().drive.kind == "ackermann"
            count = STEERING_PERIODS if car else PERIODS
            for number in range(count + SETTLING_PERIODS):
                if number < count:
                    base.drive(*drivable(bench.spec(), 0.0, sign * TURN_RATE))
                backend.step()
                turn += (float(unit.rates()[2]) - bias) * backend.period
            finding.measured.append(f"turned {way}: {turn:.3f} rad by the gyro")
            finding.expect(turn * sign > 0.02, f"turning {way} reads {turn:.3f} rad about z")


CHECKS = (Check("imu", "at rest it feels gravity alone, and turning left is positive", imu),)
