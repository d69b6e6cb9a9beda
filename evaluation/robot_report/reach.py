"""Estimate of an arm's reach by random postures."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from handcart.backends.description.robot_file import RobotFile
from handcart.robotics.geometry.transform import transform
from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.manipulation.motions.collision_model import CollisionModel
from handcart.robotics.numerics.arrays import FloatArray

SAMPLES, FEWER = (
    6000,
    1500,
)  # postures; fewer for a robot without a tray, because no position near them is searched
START_COUNT = 16  # of the search for a posture
OUT_OF_REACH_M = 0.15  # distance from all random positions of the hand


class HandReach:
    """Positions that the frame `hand` reaches while the arm touches neither itself nor the robot.

    Attributes:
        points: (n, 3) positions of the hand in the base frame in [m], of random postures.
    """

    def __init__(self, arm: ArmModel, free: CollisionModel, points: FloatArray) -> None:
        self.points = points
        self._arm, self._free = arm, free
        self._near = cKDTree(points)
        starts = np.random.default_rng(0).uniform(arm.lower, arm.upper, (START_COUNT, arm.dof))
        starts[: START_COUNT // 2] *= 0.5  # joints with several turns mostly work near their middle
        self._starts = starts

    def figures(self) -> dict[str, Any]:
        """Return the ranges of the hand's distance from the base's axis and of its height, as JSON values."""
        return {"radii_m": self.radii, "heights_m": self.heights}

    @property
    def radii(self) -> tuple[float, float]:
        """Smallest and largest distance of the hand from the base's axis, in [m]."""
        out = np.hypot(self.points[:, 0], self.points[:, 1])
        return float(out.min()), float(out.max())

    @property
    def heights(self) -> tuple[float, float]:
        """Smallest and largest height above the floor that the hand reaches, in [m]."""
        return float(self.points[:, 2].min()), float(self.points[:, 2].max())

    def reached(self, places: Sequence[tuple[float, float, float]]) -> list[bool]:
        """Return for each position whether a collision-free posture holds the hand there.

        The hand has to be upright and to point ahead.

        Args:
            places: positions of the hand in the base frame, in [m], each near the one before.
        """
        found, last = [], self._starts[:1]
        for place in places:
            posture = self._posture(place, last)
            last = last if posture is None else posture[None]
            found.append(posture is not None)
        return found

    def _posture(self, place: tuple[float, float, float], last: FloatArray) -> FloatArray | None:
        """Return a collision-free posture (n,) with the hand at a place, in [rad] or [m]; None if none is
        found.

        Inverse kinematics starts from the rows of `last` (k, n), then from random postures.
        """
        if self._near.query(place)[0] > OUT_OF_REACH_M:
            return None
        tried = (self._arm.inverse(transform(place), start, restarts=0) for start in (*last, *self._starts))
        return next((q for q in tried if q is not None and not self._free.in_collision(q)), None)


def reach_of(robot: RobotFile, arm: ArmModel, seed: int = 0) -> HandReach | None:
    """Return the positions of the hand above the floor in random postures without collision.

    None if there is no such posture.
    """
    free = CollisionModel(arm)
    rng = np.random.default_rng(seed)
    drawn = rng.uniform(arm.lower, arm.upper, (SAMPLES if robot.has_tray else FEWER, arm.dof))
    points = [arm.forward(q)[:3, 3] for q in drawn if not free.in_collision(q)]
    above = [point for point in points if point[2] > 0.0]
    return HandReach(arm, free, np.array(above)) if above else None
