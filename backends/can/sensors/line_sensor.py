"""A sensor that speaks the line protocol."""

from __future__ import annotations

import time
from abc import abstractmethod

from typing_extensions import override

from handcart.backends.description.can_sensor_spec import LineSource
from handcart.backends.live.live_sensor import Clock, LiveSensor
from handcart.robotics.numerics.arrays import FloatArray

from .line_port import LinePort
from .sensor_lines import SensorLine, read_line


class LineSensor(LiveSensor):
    """Sensor on a serial port or socket that sends its readings as text lines with time stamps.

    Damaged, implausible or late lines are dropped and counted.
    """

    KIND: str
    """First word of the sensor's lines, such as `RANGE`."""

    def __init__(self, name: str, source: LineSource, clock: Clock = time.monotonic) -> None:
        """Open the sensor's port; raise `NoSensor` if it cannot be opened."""
        super().__init__(name, source.stale_ms / 1e3, clock)
        self._port = LinePort(name, source.port, source.baud)
        self._stamp: int | None = None

    @abstractmethod
    def _taken(self, lines: list[FloatArray]) -> None:
        """Take in the values (n,) of each line of the period, at least one line, in the units of the line
        protocol.
        """

    @abstractmethod
    def _sound(self, values: FloatArray) -> bool:
        """Return True if the values (n,) of a line can be a reading: their number and their sizes are
        plausible.
        """

    def _take_in(self) -> None:
        if self.trouble:
            return
        try:
            lines = [read_line(line) for line in self._port.lines()]
        except OSError as error:
            self.trouble = f"it can't be read: {error}"
            return
        good = [line.values for line in lines if line is not None and self._new(line)]
        self.rejected += len(lines) - len(good)
        if good:
            self._good()
            self._taken(good)

    def _new(self, line: SensorLine) -> bool:
        if line.kind != self.KIND or not self._sound(line.values):
            return False
        if self._stamp is not None and line.stamp <= self._stamp:
            return False
        self._stamp = line.stamp
        return True

    @override
    def close(self) -> None:
        self._port.close()
