"""Measure the cost of one step of the particle filter: python benchmarks/field/particle_filter.py

1,024 particles, one thread, a full step: prediction, a fix, resampling, average. Beside it the same six
phases built in numpy on the resamplers of filterpy, in the same process, alternately; minima of many.
Without filterpy only our own is measured: pip install filterpy.
"""

from __future__ import annotations

import argparse
import importlib
import math
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from handcart.robotics.numerics.arrays import FloatArray, IntArray

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.outdoors.particle_filter import ParticleFilter

COUNT, TURNS, EACH = 1024, 60, 20
LEVEL_GRAVITY = np.array([0.0, 0.0, 9.81])
FORWARD, TURN, NOISE, SIGMA = 0.05, 0.01, (0.005, 0.0006), 1.0
Step = Callable[[], object]


def ours(with_fix: bool) -> Step:
    """Return a step of 100 ms of `ParticleFilter`, gyro odometry and all."""
    localizer = ParticleFilter(Pose2(0.0, 0.0, 0.0), count=COUNT)
    rates, wheels = np.array([0.0, 0.0, TURN / 0.1]), np.full(2, FORWARD)

    def step() -> None:
        localizer.predict(rates, LEVEL_GRAVITY, wheels, 0.1)
        if with_fix:
            localizer.fix(np.array(localizer.pose[:2]))

    return step


def on_filterpy(resample: Callable[[FloatArray], IntArray]) -> Step:
    """Return the same step in numpy, with one of filterpy's resamplers."""
    rng = np.random.default_rng(0)
    particles = np.zeros((COUNT, 3))
    particles[:, 2] = 0.02 * rng.standard_normal(COUNT)

    def step() -> tuple[Any, Any]:
        nonlocal particles
        way = FORWARD + NOISE[0] * rng.standard_normal(COUNT)
        turn = TURN + NOISE[1] * rng.standard_normal(COUNT)
        course = particles[:, 2] + 0.5 * turn
        particles[:, 0] += way * np.cos(course)
        particles[:, 1] += way * np.sin(course)
        particles[:, 2] += turn
        square = ((particles[:, :2] - particles[:, :2].mean(axis=0)) ** 2).sum(axis=1)
        weights = np.exp(-0.5 * square / SIGMA**2)
        weights /= weights.sum()
        particles = particles[resample(weights)]
        heading = math.atan2(np.sin(particles[:, 2]).sum(), np.cos(particles[:, 2]).sum())
        return (*particles[:, :2].mean(axis=0), heading), np.cov(particles.T)

    return step


def steps() -> dict[str, Step]:
    found = {"ours, with a fix": ours(True), "ours, without": ours(False)}
    try:
        filterpy = importlib.import_module("filterpy.monte_carlo")
    except ImportError:
        print("filterpy isn't installed, so nothing to compare with: pip install filterpy")
        return found
    for name in ("multinomial", "systematic", "stratified", "residual"):
        found[f"filterpy, {name}"] = on_filterpy(getattr(filterpy, f"{name}_resample"))
    return found


def main() -> None:
    """Print the table."""
    argparse.ArgumentParser(description=__doc__).parse_args()
    ways = steps()
    least = dict.fromkeys(ways, math.inf)
    for step in ways.values():
        step()
    for _ in range(TURNS):
        for name, step in ways.items():
            begun = time.perf_counter()
            for _ in range(EACH):
                step()
            least[name] = min(least[name], (time.perf_counter() - begun) / EACH)
    base = least["ours, with a fix"]
    for name, seconds in least.items():
        print(f"{name:24s} {1e6 * seconds:8.1f} us {seconds / base:6.1f} x")


if __name__ == "__main__":
    main()
