"""MODIFY: plan another path around what was sensed."""

from __future__ import annotations

from typing import ClassVar

from typing_extensions import override

from handcart.backends.capabilities.range_sensor import RangeSensor
from handcart.backends.robot.robot import Robot
from handcart.primitives.contract.action_primitive import ActionPrimitive, Periods
from handcart.primitives.knowledge.bumps import avoided_points, last_bump
from handcart.primitives.knowledge.place_name import PlaceName
from handcart.primitives.knowledge.world_model import Detour, ModelView
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy, Measured
from handcart.primitives.restoring.car_shunting import known_discs, plan_car_drive
from handcart.robotics.navigation.maps.bump_area import UNSEEN_SIZE_M
from handcart.robotics.numerics.arrays import FloatArray

from .driving import goal_pose, no_way, plan_drive


class Modify(ActionPrimitive):
    """Plan another path to a place, clear of all unmapped obstacles that were sensed or run into.

    Nothing moves; only the robot's knowledge changes. Without another path, the action Fails and is not tried
    again.
    """

    place: PlaceName
    """Goal of the path."""

    needs: ClassVar = (RangeSensor,)
    reads: ClassVar = ("map", "places", "obstacles", "sensed_cells", "bumps", "arm_bumps", "discs")
    writes: ClassVar = ("detour",)
    only_knowledge: ClassVar = True

    @override
    def motion(self, robot: Robot, model: ModelView) -> Periods:
        goal = goal_pose(model, self.place)
        if robot.spec.drive.kind == "ackermann":
            way = yield from robot.compute(plan_car_drive, robot, robot.pose, goal, known_discs(robot, model))
            self._take(robot, model, None if way is None else way.poses[:, :2], way.length if way else 0.0)
            return
        found = yield from robot.compute(plan_drive, robot, model, model.places[self.place])
        if found.route is None and not len(avoided_points(robot, model)) and not len(model.sensed_cells):
            raise no_way(self.place, found)
        self._take(
            robot, model, found.route and found.route.points, found.route.length if found.route else 0.0
        )

    def _take(self, robot: Robot, model: ModelView, points: FloatArray | None, length: float) -> None:
        if points is None:
            sensed = Measured("RangeSensor", "points sensed that are not on the map", len(model.obstacles))
            if len(model.bumps):
                sensed = Measured("Base", "places where it ran into something", len(model.bumps))
            raise Discrepancy(
                self._no_way(robot, model), permanent=True, measured=sensed, cause=causes.NO_ROUTE
            )
        self.evidence.points["planned"] = points
        self.found(detour_m=round(length, 3))
        model.detour = Detour(self.place, points)

    def _no_way(self, robot: Robot, model: ModelView) -> str:
        bumped = last_bump(robot.spec, model)
        if bumped is not None:
            there = f"the base ran into something at about ({bumped[0]:.2f}, {bumped[1]:.2f}) m"
            return f"no way around leads to {self.place}: {there}, taken to be up to {UNSEEN_SIZE_M} m wide"
        if not len(model.obstacles):
            if len(model.sensed_cells):
                return f"no way leads to {self.place} past what was sensed"
            return f"no way leads to {self.place} in the field"
        x, y = model.obstacles[-1]
        return f"no way around leads to {self.place}: something stands at ({x:.2f}, {y:.2f}) m"
