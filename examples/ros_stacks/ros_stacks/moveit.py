"""The real MoveIt, by its action `move_action`, planning only."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module
from typing import Any

from handcart.backends.ros2.wire.ros_link import RosLink, node_name

from .action_goal import ActionGoal
from .stacks import GoalState, Waypoints

JOINT_TOLERANCE_RAD = 1e-3
SUCCESS_CODE = 1
"""`MoveItErrorCodes.SUCCESS`."""


class MoveIt:
    """A node that asks move_group for paths."""

    def __init__(self, action: str = "move_action", package: str = "moveit_msgs") -> None:
        """Connect; raises `NoStack`."""
        self._link, self._package, self._closed = RosLink(node_name("moveit")), package, False
        try:
            self._goal = ActionGoal(self._link, package, "MoveGroup", action)
        except BaseException:
            self._link.close()
            raise

    def plan(self, group: str, names: Sequence[str], goal: Sequence[float]) -> None:
        messages = import_module(f"{self._package}.msg")
        wanted = messages.Constraints()
        wanted.joint_constraints = [
            self._constraint(messages, *item) for item in zip(names, goal, strict=True)
        ]
        asked = self._goal.type.Goal()
        asked.request.group_name, asked.request.goal_constraints = group, [wanted]
        asked.request.allowed_planning_time, asked.request.num_planning_attempts = 5.0, 3
        asked.planning_options.plan_only = True
        self._goal.send(asked)

    @staticmethod
    def _constraint(messages: Any, name: str, value: float) -> Any:
        each = messages.JointConstraint()
        each.joint_name, each.position, each.weight = name, float(value), 1.0
        each.tolerance_above = each.tolerance_below = JOINT_TOLERANCE_RAD
        return each

    def state(self) -> GoalState:
        self._link.receive()
        state = self._goal.state()
        if state is GoalState.SUCCEEDED and self._goal.result.error_code.val != SUCCESS_CODE:
            return GoalState.ABORTED
        return state

    def path(self) -> Waypoints:
        path = self._goal.result.planned_trajectory.joint_trajectory
        return Waypoints(list(path.joint_names), [list(point.positions) for point in path.points])

    def why(self) -> str:
        result = self._goal.result
        return "no result" if result is None else f"error code {result.error_code.val}"

    def close(self) -> None:
        if not self._closed:
            self._closed = True
            self._goal.cancel()
            self._link.receive()
            self._link.close()
