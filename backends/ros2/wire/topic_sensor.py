"""Base class of all readings by topic: freshness, stamps, frames."""

from __future__ import annotations

import time
from abc import abstractmethod
from collections.abc import Callable
from typing import Any

from typing_extensions import override

from handcart.backends.description.ros_spec import RosTopicSpec
from handcart.backends.live.live_sensor import Clock, LiveSensor

from .clock_steps import ClockSteps
from .frame_tree import plain

StampClock = Callable[[], float]
"""Function that returns the time of ROS, in [s]."""
CLOCK_DIFFERENCE_S = 1.0
"""Difference of a stamp from which a clock is suspected, and not a delay of messages, in [s]."""


class TopicSensor(LiveSensor):
    """Base class of sensors whose readings are messages of a ROS topic, processed once a period.

    A message is dropped if its coordinate frame is not the expected one, or if it contains numbers that are
    not finite. It is also dropped if its stamp differs from the present time by more than the topic's
    `stale_ms` in the robot's file, or is not later than the stamp of the message before. If no valid message
    follows, the `StaleSensor` error contains the reason.

    If the clock of this machine is set back, stamps after that may be earlier than those before by as much.
    """

    KIND: str
    """Type of its messages, such as `sensor_msgs/LaserScan`."""
    KEEPS_FRAME = True
    """True if all messages must have the frame of the first one, where the robot's file names none."""
    HAS_ONE_NODE = True
    """True if only one node may publish the topic."""

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
        self._clock_steps = None if stamps is None else ClockSteps(stamps, clock)
        self._step_words = ""
        self.has_other_frames = False
        """True once a message of another frame was refused."""

    def heard(self, message: Any) -> None:
        """Store a received message, which is checked and processed at the end of the period."""
        self._arrived.append(message)

    @override
    def _take_in(self) -> None:
        if self._clock_steps is not None and (step := self._clock_steps.advance()):
            self._note_clock_step(step)
        arrived, self._arrived = self._arrived, []
        good = []
        for message in arrived:
            self.doubt = self._wrong_header(message) or self._wrong(message)
            if self.doubt:
                self._refuse(message)
            else:
                good.append(message)
        if good:
            self._good()
            self._step_words = ""
            self._read(good)

    def _refuse(self, message: Any) -> None:
        """Count a dropped message; `doubt` has the reason."""
        self.rejected += 1

    @abstractmethod
    def _wrong(self, message: Any) -> str:
        """Return the reason why a message can't be a reading, as text; "" if it can."""

    @abstractmethod
    def _read(self, messages: list[Any]) -> None:
        """Take over the readings of at least one good message, the latest last."""

    def _wrong_header(self, message: Any) -> str:
        header = message.header
        wanted = self.source.frame if self.source.frame is not None else self._first_frame
        if wanted is not None and plain(header.frame_id) != plain(wanted):
            self.has_other_frames = True
            return f"its frame is {header.frame_id!r}; allowed: {wanted!r}"
        stamp = header.stamp.sec + header.stamp.nanosec / 1e9
        if stamp == 0.0:
            return "it has no stamp (0); needed: a driver that stamps its readings"
        age = 0.0 if self._stamps is None else self._stamps() - stamp
        if abs(age) > self._stale:
            what = f"{age:.3g} s old" if age > 0.0 else f"{-age:.3g} s in the future"
            return f"its stamp is {what}; allowed: {self._stale:g} s{self._clock_hint(age)}"
        last = self._stamp_before(message)
        if last is not None and stamp <= last:
            words = f"its stamp is {last - stamp:.3g} s before that of the message before"
            return f"{words}{self._set_back_hint(last - stamp)}"
        self._note_stamp(message, stamp)
        if self.KEEPS_FRAME:
            self._first_frame = header.frame_id
        return ""

    def _clock_hint(self, age: float) -> str:
        """Return which clock may be the cause of a stamp with an age in [s], as text after a semicolon; ""
        where a delay is more likely.
        """
        if self._step_words or -self._stale <= age < CLOCK_DIFFERENCE_S:
            return self._step_words
        return "; do the clocks of the robot and of this machine agree (NTP), and was one of them set?"

    def _set_back_hint(self, back_s: float) -> str:
        """Return the clock that was probably set back by a time in [s], as text after a semicolon."""
        if self._step_words or back_s < CLOCK_DIFFERENCE_S:
            return self._step_words
        return "; was the clock that stamps it set back, or do two nodes publish it?"

    def _note_clock_step(self, step_s: float) -> None:
        """Note that the clock of this machine was set.

        Args:
            step_s: time by which it was set, in [s]; negative: back.
        """
        direction = "back" if step_s < 0.0 else "forward"
        self._step_words = f"; the clock of this machine was set {direction} by {abs(step_s):.3g} s"
        if step_s < 0.0:
            self._shift_stamps(step_s)

    def _shift_stamps(self, step_s: float) -> None:
        """Convert the noted stamps to those of a clock that was set back; `step_s` in [s] is negative."""
        if self._last_stamp is not None:
            self._last_stamp += step_s

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
