"""Routes of a car over open ground, past known obstacles."""

from __future__ import annotations

import numpy as np

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.routes.tangent_path import CarPath, car_path
from handcart.robotics.numerics.arrays import BoolArray, FloatArray


def plan_car_route(
    start: Pose2, goal: Pose2, discs: FloatArray, room: float, radius: float
) -> CarPath | None:
    """Return a short path of a car past obstacles; None if none is found.

    The search begins without obstacles and adds only those discs that the found path meets. The result is as
    short as if all discs had been considered from the start.

    Args:
        start: world_T_base at the start.
        goal: world_T_base at the goal.
        discs: (n, 3) x, y and radius of each obstacle in the world, in [m].
        room: distance of the base's centre from each disc, in [m]; less for a disc to which the start is
            nearer.
        radius: radius of the turning circle, in [m].
    """
    discs = np.asarray(discs, dtype=np.float64).reshape(-1, 3)
    away = np.hypot(*(discs[:, :2] - start[:2]).T)
    grown = np.column_stack([discs[:, :2], np.minimum(discs[:, 2] + room, away - 0.01)])
    near = np.zeros(len(discs), dtype=np.bool_)
    while True:
        path = car_path(start, goal, grown[near], radius)
        if path is None:
            return None
        met = _met(path, start, goal, grown) & ~near
        if not met.any():
            return path
        near |= met


def _met(path: CarPath, start: Pose2, goal: Pose2, discs: FloatArray) -> BoolArray:
    """Return (n,) which discs a path comes into, backing included."""
    ends = [start.compose(Pose2(-path.back_before * s, 0.0, 0.0))[:2] for s in np.linspace(0.0, 1.0, 10)]
    ends += [goal.compose(Pose2(path.back_after * s, 0.0, 0.0))[:2] for s in np.linspace(0.0, 1.0, 10)]
    points = np.vstack([path.poses[:, :2], np.array(ends)])
    away = np.hypot(*np.moveaxis(points[:, None] - discs[None, :, :2], -1, 0))
    met: BoolArray = (away < discs[:, 2] - 1e-3).any(axis=0)
    return met
