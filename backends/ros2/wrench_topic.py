"""A force sensor at the wrist, by `geometry_msgs/WrenchStamped`."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from typing_extensions import override

from handcart.robotics.numerics.arrays import FloatArray

from .wire.topic_sensor import TopicSensor


class WrenchTopic(TopicSensor):
    """Force of the surroundings on the hand, from a ROS topic; the driver has to subtract the hand's weight.

    The messages of a control period are averaged.
    """

    KIND = "geometry_msgs/WrenchStamped"

    def force(self) -> FloatArray:
        """Return the force (3,) of the surroundings on the hand, in [N], in the hand frame; raise
        `StaleSensor` if the last message is too old.
        """
        self.check_fresh()
        force: FloatArray = self._mean.copy()
        return force

    @override
    def _wrong(self, message: Any) -> str:
        return "" if all(map(math.isfinite, _force(message))) else "its force is not finite"

    @override
    def _read(self, messages: list[Any]) -> None:
        self._mean = np.mean([_force(message) for message in messages], axis=0)


def _force(message: Any) -> tuple[float, float, float]:
    force = message.wrench.force
    return float(force.x), float(force.y), float(force.z)
