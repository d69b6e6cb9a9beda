"""Base class of the watches over the bus."""

from __future__ import annotations

from abc import ABC, abstractmethod

import can


def plain(frame: can.Message) -> bool:
    """Return True if CANopen nodes send frames of this kind: classic CAN data frames with an 11-bit
    identifier.
    """
    return not (frame.is_error_frame or frame.is_extended_id or frame.is_remote_frame or frame.is_fd)


class Watch(ABC):
    """Detector of one kind of fault of a CAN bus; it receives every frame, and `check` is called once a
    control period.
    """

    def begin(self, now: float) -> None:
        """Begin to monitor the drives, which have just been enabled; `now` is the time in [s]."""
        return

    def hear(self, frame: can.Message, sent: bool, now: float) -> None:
        """Process a frame that was sent or received.

        Args:
            frame: any frame on the bus.
            sent: True if this program sent it, False if it was received.
            now: time in [s].
        """
        return

    @abstractmethod
    def check(self, now: float) -> None:
        """Raise a `CanFault` if the watch has found a fault; `now` is the time in [s]."""
