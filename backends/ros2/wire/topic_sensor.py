"""Base class of all readings by topic: freshness, stamps, frames."""

from __future__ import annotations

import time
from abc import abstractmethod
from collections.abc import Callable
from typing import Any

from typing_extensions import override

from handcart.backends.description.ros_spec import RosTopicSpec
from handcart.backends.live.live_sensor import Clock, LiveSensor

StampClock = Callable[[], float]
"""Function that returns the time of ROS, in [s]."""


class TopicSensor(LiveSensor):
    """Base class of sensors whose readings are messages of a ROS topic, processed once a period.

    A message is dropped if its coordinate frame is not the expected one, or if it contains numbers that are
    not finite. It is also dropped if its stamp differs from the present time by more than the topic's
    `stale_ms` in the robot's file, or is not later than the stamp of the message before. If no valid message
    follows, the `StaleSensor` error contains the reason.
    """

    KIND: str
    """Type of its messages, such as `sensor_msgs/LaserScan`."""
    KEEPS_FRAME = True
    """True if all messages must have the frame of the first one, where the robot's file names none."""

    def __init__(
        self,
        name: str,
        source: RosTopicSpec,
        stamps: StampClock | None,
        clock: Clock = time.monotonic,
    ) -> None:
        """Begin without a message.

        Args:
            name: name of the sensor, for people.
            source: its topic.
            stamps: gives the time by which messages are stamped, in [s]; None where that is another clock's.
            clock: gives the time of arrival, in [s].
        """
        super().__init__(f"{name} ({source.topic})", source.stale_ms / 1e3, clock)
        self.source = source
        self._stamps = stamps
        self._arrived: list[Any] = []
        self._last_stamp: float | None = None
        self._first_frame: str | None = None

    def heard(self, message: Any) -> None:
        """Store a received message, which is checked and processed at the end of the period."""
        self._arrived.append(message)

    @override
    def _take_in(self) -> None:
        arrived, self._arrived = self._arrived, []
        good = []
        for message in arrived:
            self.doubt = self._wrong_header(message) or self._wrong(message)
            if self.doubt:
                self.rejected += 1
            else:
                good.append(message)
        if good:
            self._good()
            self._read(good)

    @abstractmethod
    def _wrong(self, message: Any) -> str:
        """Return the reason why a message can't be a reading, as text; "" if it can."""

    @abstractmethod
    def _read(self, messages: list[Any]) -> None:
        """Take over the readings of at least one good message, the latest last."""

    def _wrong_header(self, message: Any) -> str:
        header = message.header
        wanted = self.source.frame if self.source.frame is not None else self._first_frame
        if wanted is not None and header.frame_id != wanted:
            return f"its frame is {header.frame_id!r}; allowed: {wanted!r}"
        stamp = header.stamp.sec + header.stamp.nanosec / 1e9
        age = 0.0 if self._stamps is None else self._stamps() - stamp
        if abs(age) > self._stale:
            what = f"{age:.3g} s old" if age > 0.0 else f"{-age:.3g} s in the future"
            return f"its stamp is {what}; allowed: {self._stale:g} s"
        last = self._stamp_before(message)
        if last is not None and stamp <= last:
            return f"its stamp is {last - stamp:.3g} s before that of the message before"
        self._note_stamp(message, stamp)
        if self.KEEPS_FRAME:
            self._first_frame = header.frame_id
        return ""

    def _stamp_before(self, message: Any) -> float | None:
        """Return the stamp in [s] after which a message's stamp has to be; None before the first message."""
        return self._last_stamp

    def _note_stamp(self, message: Any, stamp: float) -> None:
        """Note the stamp in [s] of a message that is in order."""
        self._last_stamp = stamp

    def forget(self) -> None:
        """Discard all received messages, and treat the next message like the first one."""
        self._arrived, self._last_stamp, self._came, self.doubt = [], None, None, ""
        self._first_frame = None

    @override
    def close(self) -> None:
        self._arrived = []
