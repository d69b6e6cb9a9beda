"""A satellite receiver that speaks NMEA 0183."""

from __future__ import annotations

import math
import time

import numpy as np
from pyproj import Transformer
from typing_extensions import override

from handcart.backends.capabilities.gps import Fix
from handcart.backends.description.can_sensor_spec import GpsSource
from handcart.backends.live.live_gps import LiveGps
from handcart.backends.live.live_sensor import Clock

from .line_port import LinePort
from .nmea_sentence import NO_SATELLITE_FIXES, SATELLITE_FIXES, Accuracy, Position, read_sentence
from .utc_order import UtcOrder


class NmeaGps(LiveGps):
    """Satellite receiver that reads the NMEA sentences GGA and, if sent, GST.

    Positions are in the plane that touches the earth at the origin stated in the robot's file; up to 10 km
    from the origin, distances in it are correct to 1 mm. A fix is used once, and only if its time of day
    advances with this machine's clock (checked by `UtcOrder`).
    """

    def __init__(self, source: GpsSource, clock: Clock = time.monotonic) -> None:
        """Open the receiver's port; raise `NoSensor` if it cannot be opened."""
        super().__init__("the satellite receiver", source.stale_ms / 1e3, clock)
        self._source = source
        self._port = LinePort(self.name, source.port, source.baud)
        origin = f"+lat_0={source.origin_lat_deg} +lon_0={source.origin_lon_deg}"
        self._plane = Transformer.from_crs(
            "EPSG:4326", f"+proj=aeqd {origin} +datum=WGS84 +units=m", always_xy=True
        )
        self._order = UtcOrder(source.stale_ms / 1e3)
        self._accuracy: Accuracy | None = None

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
            sentence = read_sentence(line)
            if isinstance(sentence, Accuracy):
                self._accuracy = sentence
            elif sentence is not None:
                self._take_position(sentence)
            elif line[3:6] == b"GGA":  # intact, without a position
                self._answer(self._fix)
        except ValueError:
            self.rejected += 1

    def _take_position(self, position: Position) -> None:
        if not self._is_good_enough(position):
            self._answer(self._fix)
            return
        east, north = self._plane.transform(position.lon, position.lat)
        sigma = self._sigma(position)
        if not (math.isfinite(east) and math.isfinite(north) and 0.0 < sigma < math.inf):
            raise ValueError("no place")
        if not self._order.is_new(position.utc, self._now):
            self.doubt = "its times of day do not advance with the clock of this machine"
            raise ValueError(self.doubt)
        self._answer(Fix(np.array([east, north]), sigma))

    def _is_good_enough(self, position: Position) -> bool:
        """Return whether a position's quality is enough for the robot's file; note the reason if not."""
        if not position.is_fix:
            kind = NO_SATELLITE_FIXES.get(position.quality, "unknown in NMEA 0183")
            self.doubt = f"it sends places of quality {position.quality}, {kind}: they are no satellite fixes"
        elif SATELLITE_FIXES[position.quality] < SATELLITE_FIXES[self._source.quality]:
            needed = self._source.quality
            self.doubt = f"its fixes have quality {position.quality}; needed: {needed} or better"
        else:
            self.doubt = ""
        return not self.doubt

    def _sigma(self, position: Position) -> float:
        """Return the sigma in [m] that the receiver sent for this time, otherwise one from the HDOP."""
        accuracy = self._accuracy
        if accuracy is not None and abs(position.utc - accuracy.utc) <= self._stale:
            return accuracy.sigma
        return self._source.sigma_m * position.hdop

    @override
    def close(self) -> None:
        self._port.close()
