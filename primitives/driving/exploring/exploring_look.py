"""Decision of EXPLORE: the map so far, the rest of its border, and where to drive next."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from handcart.backends.robot.robot import Robot
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.exploring.free_ground import with_driven, with_gaps_closed
from handcart.robotics.navigation.exploring.frontiers import Border, Frontier, find_border
from handcart.robotics.navigation.exploring.growing_map import GrowingMap
from handcart.robotics.navigation.maps.grid_map import GridMap
from handcart.robotics.navigation.scans.likelihood_field import LikelihoodField
from handcart.robotics.numerics.arrays import FloatArray

PLANNING_CELL_M = 0.05
LEFT_M = 1.0  # around a point at which the border stays unknown, in which it is left alone
SAME_M = 1.0  # between two frontiers that are one
SIZE_WEIGHT, MAX_SIZE_M = (
    0.3,
    5.0,
)  # way in [m] that a metre of frontier is worth, and largest size that counts
KEPT_M = 2.0  # by which another frontier must be nearer than the current one
MIN_SIGMA = np.diag([0.01, 0.01, 0.005]) ** 2  # [m², rad²] of a pose on a map of cells
LEFT_WORDS = {
    "narrow": "narrower than the robot",
    "small": "shorter than the radius of the robot",
    "unreachable": "out of reach of any place where it fits",
    "far": "beyond radius_m",
    "seen": "looked at from nearby, and nothing is measured there",
    "no_route": "without a route",
}


class FrontierGoal(NamedTuple):
    """Frontier (end of the known free ground) to which the base drives, with the position from which the
    sensors look at it.
    """

    view: tuple[float, float]
    """x and y on the growing map, in [m], from which the frontier is looked at."""
    middle: tuple[float, float]
    """x and y of the middle of the frontier on the growing map, in [m]."""

    def is_same(self, other: FrontierGoal) -> bool:
        """Return whether two frontiers (borders between known and unknown ground) count as one, because their
        middles are less than `SAME_M` apart.
        """
        return math.dist(self.middle, other.middle) < SAME_M


class FrontierLook(NamedTuple):
    """Map drawn so far, with its border to unknown ground and the next frontier to explore."""

    grid: GridMap
    field: LikelihoodField
    covariance: FloatArray
    """Covariance (3, 3) of the base's pose on the map, of x, y in [m] and heading in [rad]."""
    border: Border
    target: FrontierGoal | None
    """Next frontier; None if none is left that the robot can reach."""
    facts: dict[str, float | str]


class ExploringLook:
    """Choice of the next frontier (border of known ground) to explore; frontiers that were given up are
    excluded.
    """

    def __init__(self, robot: Robot, grown: GrowingMap, radius_m: float) -> None:
        """Begin at a robot's start, on a map that grows; frontiers beyond `radius_m` from the start are
        left.
        """
        self._map, self._start, self._reach = grown, grown.poses[0], radius_m
        self._shape = robot.spec.footprint_shape
        self._left = list[tuple[float, float, str]]()
        self._postponed = list[tuple[float, float]]()

    def leave(self, point: tuple[float, float], reason: str) -> None:
        """Mark the border between known and unknown ground near a point as one not to be explored any more.

        Args:
            point: x and y on the map, in [m].
            reason: reason, a key of `LEFT_WORDS`.
        """
        self._left.append((*point, reason))

    def postpone(self, point: tuple[float, float]) -> None:
        """Choose a frontier at a point (x, y) on the map, in [m], only after all others."""
        self._postponed.append(point)

    def take(self, here: Pose2, current: FrontierGoal | None) -> FrontierLook:
        """Draw the map so far, and return it with the frontier to which the base should drive next.

        Args:
            here: current pose of the base, map_T_base.
            current: frontier to which the base drives now, and which is preferred to others; None if the base
                drives to no frontier.
        """
        if self._map.is_search_due:
            self._map.search()
        grid = self.draw()
        left = list(self._left)  # in a thread: the drive may leave another one meanwhile
        points = np.array([point[:2] for point in left]).reshape(-1, 2)
        border = find_border(grid, self._shape.inscribed, (here.x, here.y), points, LEFT_M)
        field = LikelihoodField(grid, is_drawn=True)
        _ = field.facing
        target = self._chosen(border, current)
        covariance = self._map.covariance() + MIN_SIGMA
        return FrontierLook(grid, field, covariance, border, target, self._facts(border, left))

    def draw(self, resolution: float = PLANNING_CELL_M) -> GridMap:
        """Return the map drawn so far.

        Cells are free along lidar beams, in narrow gaps between beams, and where the base was.

        Args:
            resolution: side of a cell, in [m].
        """
        drawn = with_gaps_closed(self._map.grid(resolution))
        return with_driven(drawn, self._map.poses, self._shape.inscribed)

    def _chosen(self, border: Border, current: FrontierGoal | None) -> FrontierGoal | None:
        open_ = [
            frontier
            for frontier in border.frontiers
            if frontier.view is not None and not self._is_far(frontier)
        ]
        ready = [frontier for frontier in open_ if not self._is_postponed(frontier)]
        if not ready:
            self._postponed.clear()
        best = min(ready or open_, key=lambda frontier: self._cost(frontier, current), default=None)
        return None if best is None or best.view is None else FrontierGoal(best.view, best.middle)

    def _cost(self, frontier: Frontier, current: FrontierGoal | None) -> float:
        cost = frontier.distance - SIZE_WEIGHT * min(frontier.size, MAX_SIZE_M)
        if current is not None and math.dist(current.middle, frontier.middle) < SAME_M:
            cost -= KEPT_M
        return cost

    def _is_far(self, frontier: Frontier) -> bool:
        return math.dist(frontier.middle, self._start[:2]) > self._reach

    def _is_postponed(self, frontier: Frontier) -> bool:
        return any(math.dist(frontier.middle, point) < SAME_M for point in self._postponed)

    def _facts(self, border: Border, left: list[tuple[float, float, str]]) -> dict[str, float | str]:
        """Return area and border, with the share of each reason why a part of it stays unknown.

        Args:
            border: border of the known ground.
            left: points x, y in [m], with reasons, around which `border` was left alone.
        """
        counts = {"narrow": border.cells - border.passable, "small": border.small}
        for frontier in border.frontiers:
            reason = "unreachable" if frontier.view is None else "far" if self._is_far(frontier) else ""
            counts[reason] = counts.get(reason, 0) + len(frontier.cells)
        for point, count in zip(left, border.left, strict=True):
            counts[point[2]] = counts.get(point[2], 0) + count
        shares = sorted(
            ((count, reason) for reason, count in counts.items() if reason and count), reverse=True
        )
        total = max(1, border.cells)
        words = ", ".join(f"{100.0 * count / total:.0f} % {LEFT_WORDS[reason]}" for count, reason in shares)
        return {
            "free_m2": round(border.free_m2, 1),
            "unknown_border_m": round(border.cells * PLANNING_CELL_M, 1),
            "unknown_border": words or "none",
        }
