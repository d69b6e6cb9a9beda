"""Scans of a simulated lidar among walkers, and their tracks."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from handcart.backends.simulation.passers.passer_spec import PasserSpec
from handcart.backends.simulation.passers.passers import Passers
from handcart.backends.simulation.sensors.disc_ranges import cast_at_discs
from handcart.backends.simulation.sensors.ranges import cast_rays
from handcart.backends.simulation.world.solids import FloorPlan, of_furniture
from handcart.backends.simulation.world.world_file import Furniture
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.tracking.moving_tracks import MovingTracks
from handcart.robotics.navigation.tracking.seen_free import PastScan

ANGLES = np.linspace(-np.pi, np.pi, 360, endpoint=False)
Boxes = tuple[tuple[float, ...], ...]
PERIOD_S, REACH_M = 0.05, 6.0
POSE_COVARIANCE = np.diag([1e-4, 1e-4, 1e-5])


def scans(
    passers: list[dict[str, Any]],
    seconds: float,
    boxes: Boxes = (),
    speed: float = 0.0,
    base: Callable[[], Pose2] | None = None,
    jump_m: float = 0.0,
) -> Iterator[tuple[Passers, MovingTracks, Any]]:
    """Track what a lidar sees that drives along x, or is at `base`; boxes are x, y, length, width.

    The estimated pose jumps to and fro by `jump_m` each second.
    """
    rng = np.random.default_rng(5)
    walkers = Passers([PasserSpec.model_validate(passer) for passer in passers], 0)
    pieces = [
        Furniture(name="box", x_m=x, y_m=y, size_m=(length, width, 1.0)) for x, y, length, width in boxes
    ]
    plan, tracks = FloorPlan([of_furniture(piece) for piece in pieces], 0.3, 0.3), MovingTracks(REACH_M)
    for period in range(1, round(seconds / PERIOD_S) + 1):
        time = period * PERIOD_S
        sensor = Pose2(speed * time, 0.0, 0.0) if base is None else base()
        walkers.advance(time, PERIOD_S, Pose2(50.0, 50.0, 0.0), 0.2)
        ranges = cast_rays(plan, sensor, ANGLES, time, 12.0)
        ranges = np.minimum(ranges, cast_at_discs(walkers.discs(0.3), sensor, ANGLES, 12.0))
        ranges = ranges + 0.01 * rng.standard_normal(len(ranges))
        hit = np.isfinite(ranges)
        rays = np.column_stack([np.cos(ANGLES[hit]), np.sin(ANGLES[hit])])
        believed = sensor._replace(y=sensor.y + jump_m * (int(time) % 2))
        points = believed.apply(ranges[hit, None] * rays)
        covariance = POSE_COVARIANCE + np.diag([0.25 * jump_m**2, 0.25 * jump_m**2, 0.0])
        found = tracks.take(points, PastScan(time, believed, ANGLES, ranges), covariance)
        yield walkers, tracks, (time, points, found)
