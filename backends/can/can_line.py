"""CANopen on one bus, without threads."""

from __future__ import annotations

import time
from collections.abc import Callable

import can
import canopen

_BURST = 2000  # frames that are taken in at once at most, so that a flooded bus doesn't hold the loop


class CanLine(canopen.Network):
    """A CANopen network whose frames are taken in by who waits for them, in its own thread.

    `canopen` has a thread for that, which dies of a fault of the interface and leaves old readings behind.
    Here the same call raises, nothing runs that would have to be ended, and on python-can's `virtual` the
    same frames come in the same order in every run.
    """

    def __init__(self, bus: can.BusABC, serve: Callable[[], None] | None = None) -> None:
        """Talk on a bus.

        Args:
            bus: open; closed by `close`.
            serve: lets simulated nodes on the same bus answer at once; None: nodes answer by themselves.
        """
        super().__init__(bus)
        self._bus = bus
        self._serve = serve

    def wait(self, done: Callable[[], bool], seconds: float) -> bool:
        """Take frames in until `done`; whether that came true within `seconds` of the wall clock.

        Simulated nodes have answered before this returns, or never will: then no time passes.

        Raises:
            can.CanError: of the interface.
        """
        if self._serve is not None:
            self._serve()
            self.drain()
            return done()
        end = time.monotonic() + seconds
        while not done():
            left = end - time.monotonic()
            frame = self._bus.recv(left) if left > 0.0 else None
            if frame is None:
                return done()
            self._take(frame)
        return True

    def drain(self) -> None:
        """Take in what has come so far."""
        for _ in range(_BURST):
            frame = self._bus.recv(0.0)
            if frame is None:
                return
            self._take(frame)

    def close(self) -> None:
        """Close the bus. A second call does nothing."""
        self._bus.shutdown()

    def _take(self, frame: can.Message) -> None:
        if not frame.is_extended_id and not frame.is_fd:
            # It keeps error frames and remote requests out, and logs what can't be decoded.
            self.listeners[0].on_message_received(frame)
