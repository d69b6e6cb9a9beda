"""Readings of all joints, by `sensor_msgs/JointState`."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from typing import Any

import numpy as np
from typing_extensions import override

from handcart.files.suggest import suggest
from handcart.robotics.numerics.arrays import FloatArray

from .wire.topic_sensor import TopicSensor

KEPT_STATES = 50
"""Number of messages from which the joints at the time of a picture are taken."""


class JointStates(TopicSensor):
    """Positions and efforts of joints; several publishers may each send some of them."""

    KIND = "sensor_msgs/JointState"
    KEEPS_FRAME = False  # several publishers may send joints

    def expect(self, names: Sequence[str], signs: Sequence[float]) -> None:
        """Set the joints that are needed, before the first message.

        Args:
            names: of the joints in ROS.
            signs: 1, or -1 for a joint that counts the other way round in ROS.
        """
        self._signs = dict(zip(names, signs, strict=True))
        self._positions: dict[str, float] = {}
        self._efforts: dict[str, float] = {}
        self._seen: set[str] = set()
        self._history: deque[tuple[float, dict[str, float]]] = deque(maxlen=KEPT_STATES)

    @property
    def missing(self) -> str:
        """Joints that no message has named, with what was named instead; "" if all were."""
        absent = [name for name in self._signs if name not in self._positions]
        if not absent:
            return ""
        hint = suggest(absent[0], sorted(self._seen))
        return f"{self.source.topic}: no message has the joint {', '.join(map(repr, absent))}{hint}"

    def positions(self, names: Sequence[str]) -> FloatArray:
        """Return positions (n,) in [rad] or [m]; raises `StaleSensor` without a fresh message."""
        self.check_fresh()
        return np.array([self._positions[name] for name in names])

    def positions_at(self, names: Sequence[str], stamp: float) -> FloatArray:
        """Return positions (n,) in [rad] or [m] nearest to a stamp in [s]; raises `StaleSensor`."""
        self.check_fresh()
        _, nearest = min(self._history, key=lambda each: abs(each[0] - stamp))
        return np.array([nearest.get(name, self._positions[name]) for name in names])

    def efforts(self, names: Sequence[str]) -> FloatArray:
        """Return efforts (n,) in [Nm] or [N]; NaN for a joint without one."""
        self.check_fresh()
        return np.array([self._efforts.get(name, math.nan) for name in names])

    @override
    def _wrong(self, message: Any) -> str:
        count = len(message.name)
        if len(message.position) != count:
            return f"it names {count} joints and has {len(message.position)} positions"
        known = [
            each for each, name in zip(message.position, message.name, strict=True) if name in self._signs
        ]
        return "" if all(map(math.isfinite, known)) else "a joint's position is not finite"

    @override
    def _read(self, messages: list[Any]) -> None:
        for message in messages:
            efforts = message.effort if len(message.effort) == len(message.name) else ()
            self._seen.update(message.name)
            for place, name in enumerate(message.name):
                sign = self._signs.get(name)
                if sign is not None:
                    self._positions[name] = sign * float(message.position[place])
                    if len(efforts):
                        self._efforts[name] = sign * float(efforts[place])
            stamp = message.header.stamp.sec + message.header.stamp.nanosec / 1e9
            self._history.append((stamp, dict(self._positions)))
