"""Opening a CAN interface."""

from __future__ import annotations

from collections import deque
from typing import Any

import can

from handcart.backends.description.can_spec import CanSpec

from .errors import NoInterface

UDP_MULTICAST = "udp_multicast"
_UNDER_WAY = 4096  # own frames that are waited for at most


class EchoFreeBus(can.BusABC):
    """Bus that drops the echoes of its own frames, which python-can's `udp_multicast` always delivers."""

    def __init__(self, bus: can.BusABC) -> None:
        """Take over an open bus, which `shutdown` closes."""
        self._inner = bus
        self._sent: deque[tuple[int, bytes]] = deque(maxlen=_UNDER_WAY)
        self.channel_info = bus.channel_info
        super().__init__(channel=bus.channel_info)

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        """Send a frame, as python-can's `Bus.send` does, with a time-out in [s]."""
        self._sent.append((msg.arbitration_id, bytes(msg.data)))
        self._inner.send(msg, timeout)

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        frame = self._inner.recv(timeout)
        while frame is not None and self._is_own(frame):
            frame = self._inner.recv(0.0)
        return frame, True

    def _is_own(self, frame: can.Message) -> bool:
        """Return whether a received frame is the echo of an own one; own frames that were sent before that
        one count as lost.
        """
        own = (frame.arbitration_id, bytes(frame.data))
        if own not in self._sent:
            return False
        while self._sent.popleft() != own:
            pass
        return True

    def shutdown(self) -> None:
        """Close the interface; python-can calls this method `shutdown`."""
        super().shutdown()
        self._inner.shutdown()


def open_bus(spec: CanSpec) -> can.BusABC:
    """Open the CAN interface that a robot's file names.

    Raises:
        NoInterface: the interface is missing, down, or of another bit rate.
    """
    return open_interface(spec.interface, spec.channel, 1000 * spec.bitrate_kbit_s)


def open_interface(interface: str, channel: str, bitrate: int) -> can.BusABC:
    """Open an interface of python-can; the bit rate is in [bit/s].

    Raises:
        NoInterface: the interface is missing, down, or has another bit rate.
    """
    options: dict[str, Any] = {} if interface == UDP_MULTICAST else {"bitrate": bitrate}
    try:
        bus = can.Bus(interface=interface, channel=channel, **options)
    except (can.CanError, OSError, ImportError, ValueError, TypeError) as error:
        raise NoInterface(interface, channel, bitrate, str(error)) from error
    return EchoFreeBus(bus) if interface == UDP_MULTICAST else bus
