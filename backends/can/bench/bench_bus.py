"""The program's end of a bench's bus, which can be made to fail."""

from __future__ import annotations

import errno

import can


class BenchBus(can.BusABC):
    """Wrapper of a bus that simulates faults of its interface, which can be down, have a full queue, or hold
    frames back.
    """

    def __init__(self, bus: can.BusABC) -> None:
        """Take over an open bus, which `shutdown` closes."""
        self._inner = bus
        self.channel_info = bus.channel_info
        super().__init__(channel=bus.channel_info)
        self.down = False
        """True if the interface is down, so that it neither sends nor receives, and reports that."""
        self.full = False
        """True if the interface's queue takes no more frames; sending reports that."""
        self.holds = False
        """True if sent frames stay in the interface's queue, as with an unplugged cable."""
        self.held: list[can.Message] = []
        """Frames in the interface's queue."""
        self.injected: list[can.Message] = []
        """Error frames of the controller that are received next."""
        self.condition = can.BusState.ACTIVE

    @property
    def state(self) -> can.BusState:
        """State of the interface, one of python-can's `BusState`."""
        return self.condition

    @state.setter
    def state(self, new_state: can.BusState) -> None:
        self.condition = new_state

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        """Send a frame, as python-can's `Bus.send` does.

        Args:
            msg: frame to send.
            timeout: ignored.

        Raises:
            can.CanOperationError: the interface is down or its queue is full.
        """
        if self.down:
            raise can.CanOperationError("Network is down", errno.ENETDOWN)
        if self.full:
            raise can.CanOperationError("No buffer space available", errno.ENOBUFS)
        if self.holds:
            self.held.append(msg)
        else:
            self._inner.send(msg, timeout)

    def flush_tx_buffer(self) -> None:
        """Discard the frames that the interface holds back; python-can calls this method
        `flush_tx_buffer`.
        """
        self.held.clear()

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        if self.down:
            raise can.CanOperationError("Network is down", errno.ENETDOWN)
        if self.injected:
            return self.injected.pop(0), True
        return self._inner.recv(timeout), True

    def shutdown(self) -> None:
        """Close the interface; python-can calls this method `shutdown`."""
        super().shutdown()
        self._inner.shutdown()
