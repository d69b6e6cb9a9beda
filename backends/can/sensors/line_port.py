"""Lines of text from a serial port."""

from __future__ import annotations

from collections.abc import Iterator

import serial

from handcart.backends.live.sensor_errors import NoSensor

_MOST = 1 << 16  # maximum bytes read at once
_LONGEST = 1 << 14  # bytes of a line


class LinePort:
    """A serial port or a socket that delivers lines of text; reading never waits."""

    def __init__(self, sensor: str, port: str, baud: int) -> None:
        """Open the port.

        Args:
            sensor: name of the connected sensor, for people.
            port: such as /dev/ttyUSB0 or socket://HOST:PORT.
            baud: bits a second; ignored for sockets.

        Raises:
            NoSensor: it cannot be opened.
        """
        try:
            self._port = serial.serial_for_url(port, baudrate=baud, timeout=0.0)
        except (serial.SerialException, OSError, ValueError) as error:
            wrong = f"{sensor}: {port} can't be opened: {error}"
            raise NoSensor(
                f"{wrong}; allowed: a serial port such as /dev/ttyUSB0, socket://HOST:PORT"
            ) from None
        self._begun = b""

    def lines(self) -> Iterator[bytes]:
        """Yield the complete lines that the sensor has sent since the last call, without their line ends."""
        came = self._begun + self._port.read(_MOST)
        *whole, self._begun = came.split(b"\n")
        if len(self._begun) > _LONGEST:
            self._begun = b""
        for item in whole:
            line = item.strip()
            if line:
                yield line

    def close(self) -> None:
        """Close the port."""
        self._port.close()
