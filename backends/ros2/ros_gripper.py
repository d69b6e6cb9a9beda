"""The gripper, by ROS 2."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import ClassVar

import numpy as np
from typing_extensions import override

from handcart.backends.commanded_parts import CommandedGripper
from handcart.backends.description.robot_file import GripperSpec
from handcart.backends.description.ros_spec import RosGripperSpec
from handcart.backends.plain_values import Kinds

from .joint_states import JointStates


class RosGripper(CommandedGripper):
    """Gripper whose fingers are commanded over ROS; their controller presses on an object between them.

    The fingers count as pressing if they are at rest wider open than commanded, or closed on each other.
    """

    STATE: ClassVar[Kinds] = {"_command": float, "_sent": float, "_width": float, "_still_s": float}

    def __init__(
        self,
        spec: GripperSpec,
        topic: RosGripperSpec,
        states: JointStates,
        names: Sequence[str],
        period: float,
    ) -> None:
        """Take over the readings of the fingers.

        Args:
            spec: the gripper's section of the robot's file.
            topic: topic of the gripper's controller.
            states: readings of the joints.
            names: names of the fingers' joints in ROS.
            period: control period, in [s].
        """
        self._spec, self._states, self._names, self._period = spec, states, tuple(names), period
        opening = spec.opening_mm / 1e3
        fully_open = 0.5 * opening if topic.open is None else topic.open
        self._zero, self._per_m = topic.closed, (fully_open - topic.closed) / opening
        self._away, self._rest = topic.press_mm / 1e3, topic.rest_ms / 1e3
        self._rest_speed = topic.rest_percent / 100.0 * spec.speed_mm_s / 1e3
        self._command = self._sent = self._width = 0.0
        self._still_s = 0.0

    def begin(self) -> None:
        """Set the commanded width to the measured one, before anything is sent."""
        self._width = self._measured()
        self._command = self._sent = min(self._width, self._spec.opening_mm / 1e3)

    def advance(self) -> None:
        """Update the measured width, and the time for which the fingers have been at rest."""
        now = self._measured()
        moving = abs(now - self._width) > self._rest_speed * self._period
        self._still_s = 0.0 if moving else self._still_s + self._period
        self._width = now

    @override
    def width(self) -> float:
        self._states.check_fresh()
        return self._width

    @override
    def closed_on_something(self) -> bool:
        self._states.check_fresh()
        return self._presses()

    def halt(self) -> None:
        """Hold: pressing fingers continue to press, moving fingers stop."""
        if not self._presses():
            self._command = min(self._width, self._spec.opening_mm / 1e3)

    def taken(self) -> list[float] | None:
        """Return the position of each finger's joint to send in this period, in [rad] or [m].

        None if the commanded width has not changed.
        """
        if self._command == self._sent:
            return None
        self._sent, self._still_s = self._command, 0.0
        return [self.position(self._sent)] * len(self._names)

    def seconds(self) -> float:
        """Return the time in [s] in which the fingers reach the width that was sent last; at least one
        period.
        """
        way = abs(self._sent - self._width)
        return max(self._period, way / (self._spec.speed_mm_s / 1e3))

    def position(self, width: float) -> float:
        """Return the position of the fingers' joints, in [rad] or [m], at which the pads are `width` [m]
        apart.
        """
        return self._zero + self._per_m * width

    def _presses(self) -> bool:
        """Return whether the fingers rest on something: wider open than commanded, or on each other."""
        closed = self._sent <= self._away and self._width <= 2.0 * self._away
        return self._still_s >= self._rest and (closed or self._width - self._sent > self._away)

    def _measured(self) -> float:
        position = float(np.mean(self._states.positions(self._names)))
        width = (position - self._zero) / self._per_m
        return max(0.0, width) if math.isfinite(width) else 0.0
