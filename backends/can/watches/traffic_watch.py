"""Watch over the load of the bus, and over malformed frames."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable

import can
from typing_extensions import override

from handcart.backends.can.bus.errors import Overloaded

from .watch import Watch

BUSIEST, WINDOW = 0.7, 0.1
"""Largest share of the bus that may be in use, and the time in [s] over which it is averaged."""
MAX_MALFORMED_PER_S = 10
"""Number of malformed frames in a second that is a fault."""
_FRAME, _STUFFING = 47, 8  # bits around the data; every how manieth bit is stuffed on the whole
_STUFFABLE = 34


class TrafficWatch(Watch):
    """Detector of a bus with too many frames, or with many frames that CANopen nodes never send."""

    def __init__(
        self, bitrate: int, malformed: Callable[[], int], last_malformed: Callable[[], str] = str
    ) -> None:
        """Watch a bus.

        Args:
            bitrate: bit rate of the bus, in [bit/s].
            malformed: returns the number of malformed frames so far.
            last_malformed: returns the last one as text.
        """
        self._bitrate, self._malformed, self._last_malformed = bitrate, malformed, last_malformed
        self._frames: deque[tuple[float, int]] = deque()
        self._bits = 0
        self._looked: deque[tuple[float, int]] = deque()
        self._busy_since: float | None = None

    @override
    def begin(self, now: float) -> None:
        self._frames.clear()
        self._bits = 0
        self._looked = deque([(now, self._malformed())])

    @override
    def hear(self, frame: can.Message, sent: bool, now: float) -> None:
        bits = _FRAME + 8 * frame.dlc + (_STUFFABLE + 8 * frame.dlc) // _STUFFING
        self._frames.append((now, bits))
        self._bits += bits

    def check(self, now: float) -> None:
        """Raise `Overloaded` if the bus is too busy: its load stayed above 70 % for 50 ms (`BUSIEST`,
        `WINDOW`), or at least 10 malformed frames came within a second.

        Args:
            now: present time, in [s].
        """
        while self._frames and self._frames[0][0] < now - WINDOW - 1e-9:
            self._bits -= self._frames.popleft()[1]
        load = self._bits / (WINDOW * self._bitrate)
        self._busy_since = None if load <= BUSIEST else now if self._busy_since is None else self._busy_since
        if self._busy_since is not None and now - self._busy_since >= WINDOW / 2:
            raise Overloaded(f"{100 * load:.0f} % for {WINDOW} s; allowed: {100 * BUSIEST:.0f} %")
        count = self._malformed()
        while self._looked and self._looked[0][0] < now - 1.0:
            self._looked.popleft()
        before = self._looked[0][1] if self._looked else count
        self._looked.append((now, count))
        if count - before >= MAX_MALFORMED_PER_S:
            raise Overloaded(
                f"{count - before} malformed frames within a second; allowed: {MAX_MALFORMED_PER_S - 1}"
                + (f"; the last: {last}" if (last := self._last_malformed()) else "")
            )
