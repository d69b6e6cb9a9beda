"""How far an arm reaches, by trying."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from handcart.backends.description.robot_file import RobotFile
from handcart.primitives.books.book_grip import GRIP_HEIGHT
from handcart.robotics.geometry.transform import transform
from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.manipulation.motions.collision_model import CollisionModel

SAMPLES, FEWER = 6000, 1500  # postures; where nothing is looked for near them, fewer do
TRIES = 16  # starts of the search for a posture
BEFORE_SHELF = 0.46  # [m] ahead of the base that the tips are for `aside`: shelves of return_book are at 0.47
BOARDS = (0.1, 0.3, 0.5, 0.7, 0.9, 1.1, 1.3, 1.5)  # heights of boards that are tried [m]
AHEAD = np.arange(-0.4, 1.41, 0.05)  # [m]
ASIDE = np.arange(-1.0, 1.01, 0.1)  # [m]

FAR = 0.15  # [m] from all random places of the hand: out of reach

Span = tuple[float, float] | None


@dataclass(frozen=True)
class GraspRow:
    """Where the hand, upright and pointing ahead, can hold a book that stands at some height."""

    board_m: float
    """Height of what the book stands on."""
    ahead_m: Span
    """From and to: x of the finger tips in the base frame, straight ahead (`aside_at_m` tells y)."""
    line_m: float
    """y of that line."""
    aside_m: Span
    """From and to: y of the finger tips, `BEFORE_SHELF` ahead."""


@dataclass(frozen=True)
class Reach:
    """Where the frame `hand` gets, the arm free of itself and the robot."""

    points: NDArray[np.float64]
    """(n, 3) places of it in the base frame in [m], of random joint angles."""
    grasps: Sequence[GraspRow]
    """Of a robot with a tray."""

    def figures(self) -> dict[str, Any]:
        """The same for programs."""
        grasps = [asdict(each) for each in self.grasps]
        return {"radii_m": self.radii, "heights_m": self.heights, "grasps": grasps}

    @property
    def radii(self) -> tuple[float, float]:
        """Least and largest distance from the base's axis, in [m]."""
        out = np.hypot(self.points[:, 0], self.points[:, 1])
        return float(out.min()), float(out.max())

    @property
    def heights(self) -> tuple[float, float]:
        """Least and largest height above the floor, in [m]."""
        return float(self.points[:, 2].min()), float(self.points[:, 2].max())


def reach_of(robot: RobotFile, arm: ArmModel, seed: int = 0) -> Reach | None:
    """Try random postures; for a robot with a tray also grasps of books that stand there and on boards.

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
    if not above:
        return None
    reached = np.array(above)
    return Reach(reached, _grasps(robot, _Trial(arm, free, reached)) if robot.has_tray else ())


class _Trial:
    """Whether the hand gets to a place, upright and pointing ahead."""

    def __init__(self, arm: ArmModel, free: CollisionModel, reached: NDArray[np.float64]) -> None:
        self._arm, self._free = arm, free
        self._reached = cKDTree(reached)
        starts = np.random.default_rng(0).uniform(arm.lower, arm.upper, (TRIES, arm.dof))
        starts[: TRIES // 2] *= 0.5  # joints that turn several times: most work is done near the middle
        self._starts = starts

    def reached(self, places: Sequence[tuple[float, float, float]]) -> list[bool]:
        """For each place of a line whether some free posture has the hand there."""
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
        if self._reached.query(place)[0] > FAR:
            return None
        tried = (self._arm.inverse(transform(place), start, restarts=0) for start in (*last, *self._starts))
        return next((q for q in tried if q is not None and not self._free.in_collision(q)), None)


def _grasps(robot: RobotFile, trial: _Trial) -> list[GraspRow]:
    tip = robot.finger_shape.tip if robot.gripper is not None else 0.0
    rows = [_row(trial, board, tip, 0.0) for board in BOARDS]
    tray = robot.tray_shape
    rows.append(_row(trial, tray.top, tip, tray.middle[1]))
    return sorted(rows, key=lambda row: (row.board_m, row.line_m))


def _row(trial: _Trial, board: float, tip: float, line: float) -> GraspRow:
    z = board + GRIP_HEIGHT
    ahead = [(x - tip, line, z) for x in AHEAD]
    aside = [(BEFORE_SHELF - tip, y, z) for y in ASIDE]
    reached = trial.reached(ahead)
    beside = trial.reached(aside)
    return GraspRow(board, _longest(AHEAD, reached), line, _longest(ASIDE, beside))


def _longest(values: NDArray[np.float64], good: Sequence[bool]) -> Span:
    """The longest stretch of good values."""
    best: Span = None
    start: int | None = None
    for index, each in enumerate([*good, False]):
        if each and start is None:
            start = index
        elif not each and start is not None:
            span = (float(values[start]), float(values[index - 1]))
            if best is None or span[1] - span[0] > best[1] - best[0]:
                best = span
            start = None
    return None if best is None else (round(best[0], 2) + 0.0, round(best[1], 2) + 0.0)  # no -0.0
