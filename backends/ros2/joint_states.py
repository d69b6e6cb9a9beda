"""Readings of all joints, by `sensor_msgs/JointState`."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from typing import Any

import numpy as np
from typing_extensions import override

from handcart.backends.live.sensor_errors import StaleSensor
from handcart.files.suggest import suggest
from handcart.robotics.numerics.arrays import FloatArray

from .wire.alternation import AlternationWatch
from .wire.topic_sensor import TopicSensor

KEPT_STATES = 50
"""Number of messages from which the joints at the time of a picture are taken."""


JUMP_FACTOR = 3.0
"""Ratio of the motion between two messages to that at top speed, above which it is a jump."""
JUMP_SLACK = 0.1
"""Motion added to the limit of a jump that `JUMP_FACTOR` sets, in [rad] or [m]."""
MAX_ALTERNATION = 0.01
"""Deviation of a position from those before and after it, in [rad] or [m], up to which one node may have sent
all of them.
"""


class JointStates(TopicSensor):
    """Positions and efforts of the robot's joints from the topic `joint_states`.

    Several publishers may each send some of the joints. The order and age of messages are checked for each
    joint separately, so that the joints of a publisher that stopped are detected as stale.
    """

    KIND = "sensor_msgs/JointState"
    KEEPS_FRAME = False  # several publishers may send joints
    HAS_ONE_NODE = False

    def expect(self, names: Sequence[str], signs: Sequence[float]) -> None:
        """Set the joints that are needed, before the first message.

        Args:
            names: names of the joints in ROS.
            signs: for each joint 1, or -1 if its position has the opposite sign in ROS.
        """
        self._signs = dict(zip(names, signs, strict=True))
        self._positions: dict[str, float] = {}
        self._efforts: dict[str, float] = {}
        self._seen: set[str] = set()
        self._order_s: dict[str, float] = {}
        self._stamps_s: dict[str, float] = {}
        self._taken_s: dict[str, float] = {}
        self._top_speeds: dict[str, float] = {}
        self.jumped = ""
        """Joint that moved faster than it can, or to and fro between messages, as text; "" if none did."""
        self._alternations: dict[str, AlternationWatch] = {}
        self._history: deque[tuple[float, dict[str, float]]] = deque(maxlen=KEPT_STATES)

    def limit(self, names: Sequence[str], speeds: FloatArray) -> None:
        """Set the top speeds of joints; a faster motion between two messages is treated as an implausible
        jump of the position.

        Args:
            names: names of the n joints in ROS.
            speeds: (n,) in [rad/s] or [m/s].
        """
        self._top_speeds = dict(zip(names, speeds.tolist(), strict=True))
        for name, speed in self._top_speeds.items():
            limit = MAX_ALTERNATION if math.isfinite(speed) else math.inf  # it may be wrapped at 180 deg
            self._alternations[name] = AlternationWatch((limit,))

    @property
    @override
    def age(self) -> float | None:
        """Age in [s] of the last reading of that joint whose readings are oldest; None before the first
        message.
        """
        if self._came is None:
            return None
        return self._now - min(self._taken_s.values(), default=self._came)

    @override
    def check_fresh(self) -> None:
        """Raise `StaleSensor` if the last reading of a joint of the robot is older than its time-out; the
        message names the joint.
        """
        if self._taken_s and not self.is_fresh and not self.trouble and not self.doubt:
            oldest = min(self._taken_s, key=lambda name: self._taken_s[name])
            words = f"no message has the joint {oldest!r} any more"
            raise StaleSensor(self.name, self.age, self._stale, words)
        super().check_fresh()

    @property
    def missing(self) -> str:
        """Message that lists the expected joints that no message contains; "" if all have been received."""
        absent = [name for name in self._signs if name not in self._positions]
        if not absent:
            return ""
        hint = suggest(absent[0], sorted(self._seen))
        return f"{self.source.topic}: no message has the joint {', '.join(map(repr, absent))}{hint}"

    def positions(self, names: Sequence[str]) -> FloatArray:
        """Return the positions (n,) of joints by their names in ROS, in [rad] or [m], with the robot file's
        signs; raise `StaleSensor` if a joint's last reading is too old.
        """
        self.check_fresh()
        return np.array([self._positions[name] for name in names])

    def positions_at(self, names: Sequence[str], stamp: float) -> FloatArray:
        """Return the positions (n,) of joints by their names in ROS, in [rad] or [m], of the message nearest
        to a stamp in [s]; raise `StaleSensor` if a joint's last reading is too old.
        """
        self.check_fresh()
        newest = (stamp, self._positions)
        _, nearest = min(self._history, key=lambda item: abs(item[0] - stamp), default=newest)
        return np.array([nearest.get(name, self._positions[name]) for name in names])

    def efforts(self, names: Sequence[str]) -> FloatArray:
        """Return the efforts (n,) of joints by their names in ROS, in [Nm] or [N], with the robot file's
        signs; NaN for a joint whose effort is not published. Raise `StaleSensor` if a joint's last reading is
        too old.
        """
        self.check_fresh()
        return np.array([self._efforts.get(name, math.nan) for name in names])

    @override
    def _stamp_before(self, message: Any) -> float | None:
        stamps = [self._order_s[name] for name in message.name if name in self._order_s]
        return max(stamps, default=None)

    @override
    def _note_stamp(self, message: Any, stamp: float) -> None:
        self._order_s.update(dict.fromkeys((name for name in message.name if name in self._signs), stamp))

    @override
    def _shift_stamps(self, step_s: float) -> None:
        super()._shift_stamps(step_s)
        for stamps in (self._order_s, self._stamps_s):
            stamps.update({name: stamp + step_s for name, stamp in stamps.items()})
        self._history.clear()
        self._forget_alternations()

    @override
    def forget(self) -> None:
        super().forget()
        self._order_s, self._stamps_s, self._taken_s, self.jumped = {}, {}, {}, ""
        self._history.clear()
        self._forget_alternations()

    @override
    def _wrong(self, message: Any) -> str:
        count = len(message.name)
        if len(message.position) != count:
            return f"it names {count} joints and has {len(message.position)} positions"
        known = [
            item for item, name in zip(message.position, message.name, strict=True) if name in self._signs
        ]
        return "" if all(map(math.isfinite, known)) else "a joint's position is not finite"

    @override
    def _read(self, messages: list[Any]) -> None:
        for message in messages:
            efforts = message.effort if len(message.effort) == len(message.name) else ()
            stamp = message.header.stamp.sec + message.header.stamp.nanosec / 1e9
            self._seen.update(message.name)
            for place, name in enumerate(message.name):
                sign = self._signs.get(name)
                if sign is not None:
                    self._take(name, sign * float(message.position[place]), stamp)
                    if len(efforts):
                        self._efforts[name] = sign * float(efforts[place])
            self._history.append((stamp, dict(self._positions)))

    def _take(self, name: str, position: float, stamp: float) -> None:
        """Take the position of a joint, in [rad] or [m], at a stamp in [s]."""
        if name in self._stamps_s:
            step, seconds = abs(position - self._positions[name]), stamp - self._stamps_s[name]
            most = JUMP_FACTOR * self._top_speeds.get(name, math.inf) * seconds + JUMP_SLACK
            if step > most:
                self.jumped = (
                    f"{self.source.topic}: the joint {name!r} jumps by {step:.3g} rad or m in {seconds:.3g}"
                    f" s; allowed: {most:.3g}; do two nodes send it?"
                )
        watch = self._alternations.get(name)
        found = None if watch is None else watch.note(stamp, (position,))
        if found is not None and not self.jumped:
            self.jumped = (
                f"{self.source.topic}: the joint {name!r} goes to and fro by {found.size:.2g} rad or m"
                f" between its messages; allowed: {MAX_ALTERNATION:g}. Do two nodes send it?"
            )
        self._positions[name], self._stamps_s[name], self._taken_s[name] = position, stamp, self._now

    def _forget_alternations(self) -> None:
        for watch in self._alternations.values():
            watch.forget()
