"""A satellite receiver that speaks NMEA 0183."""

from __future__ import annotations

import math
import time
from typing import Any

import numpy as np
from pynmeagps import NMEAMessageError, NMEAParseError, NMEAReader, NMEAStreamError, NMEATypeError
from pyproj import Transformer

from backends.can_sensor_spec import GpsSource
from backends.gps import Fix, Gps

from .line_port import LinePort
from .live_sensor import Clock, LiveSensor

_BROKEN = (NMEAMessageError, NMEAParseError, NMEAStreamError, NMEATypeError, ValueError, UnicodeDecodeError)
_BETTER = {0: 0, 1: 1, 2: 2, 5: 3, 4: 4}  # qualities of GGA, the best last: 4 is RTK fixed, 5 RTK float


class NmeaGps(LiveSensor, Gps):
    """Takes GGA, and GST where the receiver sends it; positions are told in a plane about the task's origin.

    In that plane a distance is right to 1 mm up to 10 km from the origin.
    """

    def __init__(self, source: GpsSource, clock: Clock = time.monotonic) -> None:
        """Open its port; raises `NoSensor`."""
        super().__init__("the satellite receiver", source.stale_ms / 1e3, clock)
        self._source = source
        self._port = LinePort(self.name, source.port, source.baud)
        origin = f"+lat_0={source.origin_lat_deg} +lon_0={source.origin_lon_deg}"
        self._plane = Transformer.from_crs(
            "EPSG:4326", f"+proj=aeqd {origin} +datum=WGS84 +units=m", always_xy=True
        )
        self._sigma: float | None = None
        self._fix: Fix | None = None

    def fix(self) -> Fix | None:
        """See `Gps`."""
        return self._fix

    def _take_in(self) -> None:
        self._fix = None
        if self.trouble:
            return
        try:
            lines = list(self._port.lines())
        except OSError as error:
            self.trouble = f"it can't be read: {error}"
            return
        for line in lines:
            self._take(line)

    def _take(self, line: bytes) -> None:
        try:
            told: Any = NMEAReader.parse(line + b"\r\n")
            if told is None:
                raise ValueError("no sentence")
            if told.msgID == "GST":
                self._sigma = math.hypot(float(told.stdLat), float(told.stdLong)) / math.sqrt(2.0)
            elif told.msgID == "GGA":
                self._take_position(told)
        except _BROKEN:
            self.rejected += 1

    def _take_position(self, told: Any) -> None:
        quality = _BETTER.get(int(told.quality), 0)
        if quality < _BETTER[self._source.quality]:
            return
        east, north = self._plane.transform(float(told.lon), float(told.lat))
        sigma = self._sigma if self._sigma is not None else self._source.sigma_m * float(told.HDOP)
        if not (math.isfinite(east) and math.isfinite(north) and sigma > 0.0):
            raise ValueError("no place")
        self._fix = Fix(np.array([east, north]), sigma)
        self._good()

    def close(self) -> None:
        """See `LiveSensor`."""
        self._port.close()
