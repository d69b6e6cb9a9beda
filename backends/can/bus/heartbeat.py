"""Our own heartbeat."""

from __future__ import annotations

from collections.abc import Callable

from .can_line import CanLine

_OPERATIONAL = 5
_EARLY = 0.9  # of its time: a period is never quite as long as it should be


class Heartbeat:
    """CANopen heartbeat of this program, sent to the drives by the control loop, never by a timer.

    If the loop hangs, the heartbeat stops, and the drives stop by themselves.
    """

    def __init__(self, line: CanLine, node: int, every: float, clock: Callable[[], float]) -> None:
        """Set up a heartbeat without sending one.

        Args:
            line: network of the drives.
            node: node ID of this program.
            every: time between two heartbeats, in [s].
            clock: returns the time in [s].
        """
        self._line, self._node, self._every, self._clock = line, node, every, clock
        self._sent: float | None = None

    def beat(self) -> None:
        """Send a heartbeat if at least 90 % of the interval between heartbeats have passed since the last
        one.
        """
        now = self._clock()
        if self._sent is None or now - self._sent >= _EARLY * self._every:
            self._line.send_message(0x700 + self._node, bytes([_OPERATIONAL]))
            self._sent = now
