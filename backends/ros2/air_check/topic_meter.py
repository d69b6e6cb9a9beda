"""Rate, gaps, stamps and frames of one topic."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np


class MeasuredTopic(NamedTuple):
    """Rate and longest gap of a topic's messages, age of their stamps at arrival, and frames in their
    headers.
    """

    topic: str
    kind: str
    """Type of its messages."""
    messages: int
    """Number of messages."""
    rate_hz: float
    """Messages a second; 0 with fewer than two."""
    max_gap_s: float
    """Longest time without a message, up to the end of the measurement, in [s]."""
    age_s: float | None
    """Median age of the stamps at arrival, in [s]; None without messages."""
    oldest_s: float | None
    """Greatest age of a stamp at arrival, in [s]; None without messages."""
    frames: tuple[str, ...]
    """Frames named in the headers."""


class TopicMeter:
    """Measurement of the rate, gaps and ages of the messages of one ROS topic since the method `begin` was
    called.
    """

    def __init__(
        self, topic: str, kind: str, clock: Callable[[], float], stamps: Callable[[], float]
    ) -> None:
        """Prepare to measure a topic.

        Args:
            topic: name of the topic.
            kind: type of its messages.
            clock: returns the time of arrival, in [s].
            stamps: returns the time of ROS by which messages are stamped, in [s].
        """
        self.topic, self.kind = topic, kind
        self._clock, self._stamps = clock, stamps
        self.last: Any = None
        """The last message; None before the first."""
        self.begin()

    def begin(self) -> None:
        """Start to measure the topic's messages; those that arrived earlier no longer count."""
        self._begun = self._clock()
        self._arrivals: list[float] = []
        self._ages: list[float] = []
        self._frames: dict[str, None] = {}

    def heard(self, message: Any) -> None:
        """Count a message of the topic, and record the time of its arrival, its stamp and its frame."""
        self.last = message
        self._arrivals.append(self._clock())
        frames = getattr(message, "transforms", None)
        if frames == []:
            return
        header = frames[0].header if frames else message.header
        self._ages.append(self._stamps() - header.stamp.sec - header.stamp.nanosec / 1e9)
        self._frames[header.frame_id] = None

    def measured(self) -> MeasuredTopic:
        """Return the rate, longest gap, ages and frame IDs of the topic's messages since `begin` was
        called.
        """
        times = np.array([self._begun, *self._arrivals, self._clock()])
        count = len(self._arrivals)
        span = times[-2] - times[1] if count > 1 else 0.0
        return MeasuredTopic(
            self.topic,
            self.kind,
            count,
            (count - 1) / float(span) if span > 0.0 else 0.0,
            float(np.diff(times).max()),
            float(np.median(self._ages)) if count else None,
            max(self._ages, key=abs) if count else None,
            tuple(self._frames),
        )
