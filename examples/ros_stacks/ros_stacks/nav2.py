"""The real Nav2, by its action `navigate_to_pose`."""

from __future__ import annotations

import math
from typing import Any

from handcart.backends.ros2.wire.messages import set_stamp
from handcart.backends.ros2.wire.ros_link import RosLink, node_name

from .action_goal import ActionGoal
from .stacks import GoalState, Speeds

SPEEDS_TOPIC = "nav2/cmd_vel"
"""Topic to which Nav2's `cmd_vel` is remapped: `cmd_vel` itself belongs to handcart alone."""
LAST_PASSES = 3


class Nav2:
    """A node that sends goals to Nav2, and hears its speeds."""

    def __init__(self, action: str = "navigate_to_pose", package: str = "nav2_msgs") -> None:
        """Connect; raises `NoStack`."""
        self._link, self._closed = RosLink(node_name("nav2")), False
        self._newest: Speeds | None = None
        try:
            self._goal = ActionGoal(self._link, package, "NavigateToPose", action)
        except BaseException:
            self._link.close()
            raise
        self._link.subscribe("geometry_msgs/Twist", SPEEDS_TOPIC, self._heard)

    def go_to(self, x: float, y: float, heading: float) -> None:
        goal = self._goal.type.Goal()
        goal.pose.header.frame_id = "map"
        set_stamp(goal.pose.header, self._link.now())
        goal.pose.pose.position.x, goal.pose.pose.position.y = float(x), float(y)
        goal.pose.pose.orientation.z = math.sin(0.5 * heading)
        goal.pose.pose.orientation.w = math.cos(0.5 * heading)
        self._goal.send(goal)

    def state(self) -> GoalState:
        self._link.receive()
        return self._goal.state()

    def speeds(self) -> Speeds | None:
        newest, self._newest = self._newest, None
        return newest

    def cancel(self) -> None:
        self._goal.cancel()

    def close(self) -> None:
        if not self._closed:
            self._closed = True
            self._goal.cancel()
            for _ in range(LAST_PASSES):
                self._link.receive()
            self._link.close()

    def _heard(self, message: Any) -> None:
        self._newest = Speeds(float(message.linear.x), float(message.angular.z))
