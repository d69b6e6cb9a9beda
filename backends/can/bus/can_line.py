"""CANopen on one bus, without threads."""

from __future__ import annotations

import errno
import time
from collections.abc import Callable
from contextlib import suppress

import can
import canopen

from .errors import QueueFull

Heard = Callable[[can.Message, bool], None]
"""Callback for each frame; its second argument is True if the frame was sent, False if received."""

_BURST = 2000  # maximum frames read at once: a flooded bus must not hold up the loop
_LOST = 3  # frames in a row that the interface may refuse to queue
_FULL = (errno.ENOBUFS, errno.EAGAIN)


class CanLine(canopen.Network):
    """A CANopen network that receives frames in the thread of its caller.

    `canopen.Network` receives in a thread of its own. A fault of the interface ends that thread unnoticed,
    and old readings remain. In this class a fault raises in the call that receives, there is no thread to
    end, and on python-can's interface `virtual` the frames arrive in the same order in every run.
    """

    def __init__(
        self, bus: can.BusABC, serve: Callable[[], None] | None = None, heard: Heard | None = None
    ) -> None:
        """Connect to a bus.

        Args:
            bus: open bus, which `close` closes.
            serve: lets simulated nodes on the same bus answer at once; None: nodes answer by themselves.
            heard: called with each frame that is sent or received, of any kind.
        """
        super().__init__(bus)
        self._bus = bus
        self._serve = serve
        self._heard: list[Heard] = [] if heard is None else [heard]
        self._refused = 0
        self.malformed = 0
        """Number of frames that no CANopen node sends, or that could not be decoded."""
        self.last_malformed = ""
        """The last of these frames, as text; empty before the first."""

    def listen(self, heard: Heard) -> None:
        """Register a further function that is called with each frame, and with True if this program sent the
        frame.
        """
        self._heard.append(heard)

    def send_message(self, can_id: int, data: bytes, remote: bool = False) -> None:
        """Send a frame; if the interface's queue is full, the frame is lost.

        Args:
            can_id: identifier; above 7FFh it is sent as an extended identifier of 29 bits.
            data: data of the frame.
            remote: True for a remote frame, which requests data.

        Raises:
            QueueFull: several frames in a row were lost.
            can.CanError: the interface reports an error.
        """
        # A copy: frames in the interface's queue must not change when the buffer is refilled.
        frame = can.Message(
            arbitration_id=can_id, data=bytes(data), is_remote_frame=remote, is_extended_id=can_id > 0x7FF
        )
        try:
            self._bus.send(frame)
        except can.CanOperationError as error:
            if error.error_code not in _FULL and "full" not in str(error).lower():
                raise
            self._refused += 1
            if self._refused >= _LOST:
                raise QueueFull(self._refused) from error
            return
        self._refused = 0
        for heard in self._heard:
            heard(frame, True)

    def wait(self, done: Callable[[], bool | None], seconds: float) -> bool:
        """Receive frames until `done()` is true; return False if it is still false after `seconds`.

        With simulated nodes the call returns at once, because they answer at once or never.

        Args:
            done: returns True if no more frames are needed; it is called after each frame.
            seconds: longest time by the wall clock, in [s]; frames that arrived before its end are received
                also by a process that is late.

        Raises:
            can.CanError: the interface reports an error.
        """
        if self._serve is not None:
            self._serve()
            self.drain()
            return bool(done())
        end = time.monotonic() + seconds
        late = 0
        while not done():
            left = max(0.0, end - time.monotonic())
            late += left == 0.0
            frame = self._bus.recv(left) if late <= _BURST else None
            if frame is None:
                return bool(done())
            self._take(frame)
        return True

    def drain(self) -> None:
        """Receive all frames that have arrived so far."""
        for _ in range(_BURST):
            frame = self._bus.recv(0.0)
            if frame is None:
                return
            self._take(frame)

    def flush(self) -> None:
        """Discard the frames that the interface has not sent yet."""
        with suppress(NotImplementedError, can.CanError):  # `stop` must send the remaining frames
            self._bus.flush_tx_buffer()

    @property
    def interface_state(self) -> can.BusState:
        """State of the CAN controller that the interface reports (active, passive or bus-off)."""
        return self._bus.state

    def close(self) -> None:
        """Close the bus. A second call does nothing."""
        self._bus.shutdown()

    def _take(self, frame: can.Message) -> None:
        for heard in self._heard:
            heard(frame, False)
        if frame.is_error_frame:
            return
        if frame.is_extended_id or frame.is_fd or frame.is_remote_frame:
            self._count_malformed(frame, "CANopen has no extended, CAN FD or remote frames")
            return
        try:
            self.notify(frame.arbitration_id, frame.data, frame.timestamp)
        except Exception as error:  # decoders and listeners raise anything, and the next frame must be heard
            self._count_malformed(frame, f"{type(error).__name__}: {error}")

    def _count_malformed(self, frame: can.Message, why: str) -> None:
        self.malformed += 1
        self.last_malformed = f"{frame.arbitration_id:03X}h, {frame.dlc} bytes: {why}"
