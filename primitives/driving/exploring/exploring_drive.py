"""One drive of EXPLORE: MOVE_TO to a place on the map so far."""

from __future__ import annotations

import math

import numpy as np

from handcart.backends.robot.robot import Robot
from handcart.primitives.contract.action_primitive import ActionPrimitive, Periods
from handcart.primitives.driving.move_to import MoveTo
from handcart.primitives.knowledge.place import Place
from handcart.primitives.knowledge.world_model import ModelView, WorldModel
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.maps.grid_map import GridMap

NEAR_M, NEAR_RAD = 0.25, math.radians(30.0)  # of a place to look from: near enough
VIEW_TOLERANCE_MM, VIEW_TOLERANCE_DEG = 400.0, 30.0
GOAL_NAME = "the frontier"
START_NAME = "the start"


class ExploringDrive:
    """One drive of the primitive EXPLORE to a pose on the map that it has drawn until then.

    The world model does not contain that map yet.
    """

    def __init__(self, model: ModelView, grid: GridMap, goal: Pose2, wait_s: float, name: str) -> None:
        """Create a drive; nothing is planned yet.

        Args:
            model: world model of the primitive, of which obstacles and bumps are used.
            grid: the map so far.
            goal: map_T_base at the end of the drive.
            wait_s: time to wait for a passer-by, in [s].
            name: name of the goal in messages.
        """
        self.goal = goal
        place = Place(
            x_m=goal.x,
            y_m=goal.y,
            heading_deg=math.degrees(goal.theta),
            tolerance_mm=VIEW_TOLERANCE_MM,
            tolerance_deg=VIEW_TOLERANCE_DEG,
        )
        inner = WorldModel(
            grid,
            {name: place},
            obstacles=model.obstacles.copy(),
            bumps=model.bumps.copy(),
            arm_bumps=model.arm_bumps.copy(),
        )
        self._move = MoveTo(place=name, wait_s=wait_s)
        declares: ActionPrimitive = self._move
        self._view = inner.view(declares)

    def periods(self, robot: Robot) -> Periods:
        """Drive to the goal, one period at a time.

        Raises:
            Discrepancy: no route leads to the goal, or the base makes no progress.
        """
        periods = self._move.motion(robot, self._view)
        is_first = True
        while True:
            if not is_first:
                self._move.watch(robot, self._view)
            is_first = False
            try:
                next(periods)
            except StopIteration:
                return
            yield

    def is_near(self, pose: Pose2) -> bool:
        """Return whether a pose map_T_base is within `NEAR_M` and `NEAR_RAD` of the goal, near enough to
        sense the frontier (border of unknown ground).
        """
        return pose.distance(self.goal) < NEAR_M and pose.turn(self.goal) < NEAR_RAD


def looking_at(view: tuple[float, float], point: tuple[float, float]) -> Pose2:
    """Return the pose map_T_base at the position `view` whose heading is towards `point`.

    Args:
        view: x and y of the base on the map, in [m].
        point: x and y of the point to look at on the map, in [m].
    """
    x, y = np.subtract(point, view).tolist()
    return Pose2(*view, math.atan2(y, x))
