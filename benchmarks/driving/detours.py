"""A car past round obstacles: python benchmarks/driving/detours.py [--fields N]

Fields of 1 to 5 discs, 0.3 to 2 m in radius, between a start and a goal 12 m ahead with the same heading. The
path keeps 0.7 m from the obstacles (the rear axle's middle) with a turning circle of 2.1 m, of which the
steering could do 2.0; it is then driven by pure pursuit with a localization that is 0.05 m off, and the body
(0.7 m wide, 0.8 m ahead of the rear axle and 0.3 m behind) is checked against the obstacles. Lengths are
relative to the analytic detour: tangents and arcs at 0.7 m without any limit to curvature or heading, which
nothing that keeps the distance can beat. Fields without any such detour are not counted.
"""

from __future__ import annotations

import argparse
import math
import sys
import time
from pathlib import Path
from typing import NamedTuple

import numpy as np
from rich.progress import track

from handcart.robotics.numerics.arrays import FloatArray

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.following.pure_pursuit import PurePursuit
from handcart.robotics.navigation.routes.tangent_path import CarPath, car_path, shortest_detour

START, GOAL = Pose2(0.0, 0.0, 0.0), Pose2(12.0, 0.0, 0.0)
AROUND, RADIUS, DT, OFF = 0.7, 2.1, 0.05, 0.05
AHEAD, BEHIND, HALF_WIDTH = 0.8, 0.3, 0.35


class Drive(NamedTuple):
    """Result of one path."""

    length: float
    nearest: float  # [m] between body and obstacles, negative in them
    missed: float  # [m] from the goal


def field(rng: np.random.Generator) -> FloatArray:
    """Return (n, 3) discs with room before start and goal for the turning circle."""
    while True:
        count = rng.integers(1, 6)
        discs = np.column_stack(
            [rng.uniform(2.0, 10.0, count), rng.uniform(-3.0, 3.0, count), rng.uniform(0.3, 2.0, count)]
        )
        room = min(_gap(discs, end) for end in (START, GOAL))
        if room > AROUND + RADIUS:
            return discs


def _gap(discs: FloatArray, pose: Pose2) -> float:
    return float((np.hypot(*(discs[:, :2] - pose[:2]).T) - discs[:, 2]).min())


def body_gap(discs: FloatArray, pose: Pose2) -> float:
    """Distance of the body's rectangle from the nearest disc, in [m]."""
    local = pose.inverse().apply(discs[:, :2])
    outside_x = np.maximum(np.maximum(local[:, 0] - AHEAD, -BEHIND - local[:, 0]), 0.0)
    outside_y = np.maximum(np.abs(local[:, 1]) - HALF_WIDTH, 0.0)
    return float((np.hypot(outside_x, outside_y) - discs[:, 2]).min())


def drive(path: CarPath, discs: FloatArray, rng: np.random.Generator) -> Drive:
    """Follow a path at up to 0.5 m/s; steering turns at most 0.5 / m a second."""
    car = Car(discs, rng)
    car.back(path.back_before)
    control = PurePursuit(path.poses)
    for _ in range(4000):
        speed, wanted = control.command(car.believed, car.speed, DT)
        if speed <= 1e-3:
            break
        car.move(speed, wanted)
    car.back(path.back_after)
    return Drive(car.length, car.nearest, car.pose.distance(GOAL))


class Car:
    """True motion of a car with slow steering and localization errors."""

    def __init__(self, discs: FloatArray, rng: np.random.Generator) -> None:
        self.pose, self.speed, self.length, self.nearest = START, 0.0, 0.0, math.inf
        self._discs, self._rng, self._bend = discs, rng, 0.0
        self._off = OFF * rng.standard_normal(2)

    @property
    def believed(self) -> Pose2:
        return Pose2(self.pose.x + self._off[0], self.pose.y + self._off[1], self.pose.theta)

    def back(self, way: float) -> None:
        """Straight backwards."""
        for _ in range(round(way / (0.2 * DT))):
            self.move(-0.2, 0.0)
        self.speed = 0.0

    def move(self, speed: float, wanted: float) -> None:
        self.speed = speed
        self._bend += max(-0.5 * DT, min(0.5 * DT, wanted - self._bend))
        turn = speed * DT * self._bend
        course = self.pose.theta + 0.5 * turn
        x = self.pose.x + speed * DT * math.cos(course)
        self.pose = Pose2(x, self.pose.y + speed * DT * math.sin(course), self.pose.theta + turn)
        self._off = self._off * (1.0 - DT / 5.0) + OFF * math.sqrt(
            2.0 * DT / 5.0
        ) * self._rng.standard_normal(2)
        self.length += abs(speed) * DT
        self.nearest = min(self.nearest, body_gap(self._discs, self.pose))


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--fields", type=int, default=1000)
    chosen = parser.parse_args()
    planned, driven, nearest, missed, times, tightest = [], [], [], [], [], []
    unsolved, impossible, backed = 0, 0, 0
    for seed in track(range(chosen.fields), "fields"):
        rng = np.random.default_rng(seed)
        discs = field(rng)
        grown = discs + np.array([0.0, 0.0, AROUND])
        detour = shortest_detour(np.array(START[:2]), np.array(GOAL[:2]), grown)
        begun = time.perf_counter()
        path = car_path(START, GOAL, grown, RADIUS)
        times.append(time.perf_counter() - begun)
        if math.isinf(detour):
            impossible += 1
            continue
        if path is None:
            unsolved += 1
            continue
        backed += path.back_before + path.back_after > 0.0
        result = drive(path, discs, rng)
        planned.append(path.length / detour)
        driven.append(result.length / detour)
        nearest.append(result.nearest)
        missed.append(result.missed)
        tightest.append(float(np.abs(path.curvatures).max()))
    print(f"fields {chosen.fields}: no way {impossible}, not found {unsolved}, with backing {backed}")
    print(f"collisions {sum(gap < 0.0 for gap in nearest)}, nearest {min(nearest):.3f} m")
    for name, values in (("planned", planned), ("driven", driven)):
        middle, high, most = np.percentile(values, [50, 95, 100])
        over = sum(value > 1.1 for value in values)
        print(f"{name} / detour: median {middle:.3f}, 95 % {high:.3f}, most {most:.3f}, {over} over 1.10")
    print(f"goal missed by {np.median(missed):.3f} m, most {max(missed):.3f} m")
    print(f"sharpest {max(tightest):.3f} 1/m")
    print(f"planning {1e3 * np.median(times):.1f} ms, most {1e3 * max(times):.1f} ms")


if __name__ == "__main__":
    main()
