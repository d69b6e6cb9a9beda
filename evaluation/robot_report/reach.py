"""How far an arm reaches, by trying."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from handcart.backends.description.robot_file import RobotFile
from handcart.robotics.geometry.transform import transform
from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.manipulation.motions.collision_model import CollisionModel

SAMPLES, FEWER = 6000, 1500  # postures; of a robot without a tray fewer: nothing is looked for near them
TRIES = 16  # starts of the search for a posture
FAR = 0.15  # [m] from all random places of the hand: out of reach


class Reach:
    """Where the frame `hand` gets, the arm free of itself and the robot.

    Attributes:
        points: (n, 3) places of it in the base frame in [m], of random joint angles.
    """

    def __init__(self, arm: ArmModel, free: CollisionModel, points: NDArray[np.float64]) -> None:
        self.points = points
        self._arm, self._free = arm, free
        self._near = cKDTree(points)
        starts = np.random.default_rng(0).uniform(arm.lower, arm.upper, (TRIES, arm.dof))
        starts[: TRIES // 2] *= 0.5  # joints that turn several times: most work is done near the middle
        self._starts = starts

    def figures(self) -> dict[str, Any]:
        """The same for programs."""
        return {"radii_m": self.radii, "heights_m": self.heights}

    @property
    def radii(self) -> tuple[float, float]:
        """Least and largest distance from the base's axis, in [m]."""
        out = np.hypot(self.points[:, 0], self.points[:, 1])
        return float(out.min()), float(out.max())

    @property
    def heights(self) -> tuple[float, float]:
        """Least and largest height above the floor, in [m]."""
        return float(self.points[:, 2].min()), float(self.points[:, 2].max())

    def reached(self, places: Sequence[tuple[float, float, float]]) -> list[bool]:
        """For each place of a line, in the base frame in [m], whether some free posture has the hand there,
        upright and pointing ahead."""
        found, last = [], self._starts[:1]
        for place in places:
            posture = self._posture(place, last)
            last = last if posture is None else posture[None]
            found.append(posture is not None)
        return found

    def _posture(
        self, place: tuple[float, float, float], last: NDArray[np.float64]
    ) -> NDArray[np.float64] | None:
        """By descents from the last posture and from random ones."""
        if self._near.query(place)[0] > FAR:
            return None
        tried = (self._arm.inverse(transform(place), start, restarts=0) for start in (*last, *self._starts))
        return next((q for q in tried if q is not None and not self._free.in_collision(q)), None)


def reach_of(robot: RobotFile, arm: ArmModel, seed: int = 0) -> Reach | None:
    """Try random postures.

    Args:
        robot: by its file.
        arm: its arm.
        seed: of what is random.

    Returns:
        None where no posture was found that is free and has the hand above the floor.
    """
    free = CollisionModel(arm)
    rng = np.random.default_rng(seed)
    drawn = rng.uniform(arm.lower, arm.upper, (SAMPLES if robot.has_tray else FEWER, arm.dof))
    points = [arm.forward(q)[:3, 3] for q in drawn if not free.in_collision(q)]
    above = [point for point in points if point[2] > 0.0]
    return Reach(arm, free, np.array(above)) if above else None
