"""Server of a simulated robot's range sensor to a program in another process."""

from __future__ import annotations

import contextlib
import socket

from handcart.backends.capabilities.range_sensor import RangeSensor

from .sensor_lines import sensor_line


class RangeServer:
    """Server that listens on a local port and sends each lidar scan to its clients, as a line of text with a
    checksum.
    """

    def __init__(self, sensor: RangeSensor, port: int) -> None:
        """Begin to listen; raises OSError."""
        self._sensor = sensor
        self._listening = socket.create_server(("127.0.0.1", port), backlog=1)
        self._listening.setblocking(False)
        self.port = self._listening.getsockname()[1]
        """Port on which the server listens; the system chose it if 0 was given."""
        self._heard: list[socket.socket] = []

    def send(self, time: float) -> None:
        """Send this period's scan without waiting; clients that do not read are disconnected.

        Args:
            time: time of the sensor's clock, in [s].
        """
        with contextlib.suppress(BlockingIOError):  # no client is connecting
            caller, _ = self._listening.accept()
            caller.setblocking(False)
            self._heard.append(caller)
        if not self._heard:
            return
        line = sensor_line("RANGE", round(1e3 * time), self._sensor.scan().ranges)
        for item in list(self._heard):
            try:
                sent = item.send(line)
            except OSError:
                sent = 0
            if sent != len(line):
                item.close()
                self._heard.remove(item)

    def close(self) -> None:
        """Close the port, and the connections to all clients."""
        for item in (self._listening, *self._heard):
            item.close()
