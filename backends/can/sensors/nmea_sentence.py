"""Sentences of NMEA 0183 for a receiver's position (GGA) and its accuracy (GST)."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from typing import NamedTuple

from .sensor_lines import body_of
from .strict_number import strict_number

_TIME = r"(?P<hour>\d\d)(?P<minute>\d\d)(?P<second>\d\d(?:\.\d+)?)"
_LAT = r"(?P<lat_deg>\d\d)(?P<lat_min>\d\d(?:\.\d+)?),(?P<north>[NS])"
_LON = r"(?P<lon_deg>\d{3})(?P<lon_min>\d\d(?:\.\d+)?),(?P<east>[EW])"
_GGA = re.compile(
    rf"[A-Z]{{2}}GGA,{_TIME},{_LAT},{_LON},(?P<quality>\d),\d*,(?P<hdop>\d+(?:\.\d+)?)(?:,[^,]*){{6}}",
    re.ASCII,
)
_GST = re.compile(rf"[A-Z]{{2}}GST,{_TIME}(?:,[^,]*){{4}},(?P<lat>[\d.]*),(?P<lon>[\d.]*),[^,]*", re.ASCII)
_NOWHERE = re.compile(r"[A-Z]{2}GGA,[\d.]*,,,,,.*", re.ASCII)


SATELLITE_FIXES = {1: 1, 3: 2, 2: 3, 5: 4, 4: 5}
"""Rank of the qualities of GGA that satellites give, by NMEA 0183.

1 single, 3 precise positioning service (PPS), 2 differential or SBAS, 5 RTK float, 4 RTK fixed.
"""
NO_SATELLITE_FIXES = {0: "invalid", 6: "estimated by dead reckoning", 7: "typed in by hand", 8: "simulated"}
"""The other qualities of GGA: places that no satellite measured."""


class Position(NamedTuple):
    """Position that a satellite receiver reports in an NMEA sentence GGA."""

    utc: float
    """Time of day (UTC), in [s]."""
    lat: float
    """Latitude, north positive, in [deg]."""
    lon: float
    """Longitude, east positive, in [deg]."""
    quality: int
    """A key of `SATELLITE_FIXES` or `NO_SATELLITE_FIXES`; others are not in the standard."""
    hdop: float

    @property
    def is_fix(self) -> bool:
        """True if satellites measured the position."""
        return self.quality in SATELLITE_FIXES


class Accuracy(NamedTuple):
    """Accuracy of a position fix that a satellite receiver reports in an NMEA sentence GST."""

    utc: float
    """Time of day (UTC) to which the accuracy belongs, in [s]."""
    sigma: float
    """Sigma of the position on each axis, in [m]."""


def read_sentence(line: bytes) -> Position | Accuracy | None:
    """Return a parsed GGA or GST sentence; None for any other kind, or if the receiver has no position.

    Raises:
        ValueError: the sentence is damaged, or has another form than in NMEA 0183.
    """
    body = body_of(line).decode("ascii")
    match body[2:5]:
        case "GGA":
            return None if _NOWHERE.fullmatch(body) else _position(_fields(_GGA, body))
        case "GST":
            return _accuracy(_fields(_GST, body))
    return None


def _fields(pattern: re.Pattern[str], body: str) -> Mapping[str, str]:
    found = pattern.fullmatch(body)
    if found is None:
        raise ValueError("no such sentence")
    return found.groupdict()


def _position(fields: Mapping[str, str]) -> Position:
    lat, lon = (_degrees(fields, axis) for axis in ("lat", "lon"))
    if lat > 90.0 or lon > 180.0:
        raise ValueError("no such place")
    return Position(
        _utc(fields),
        lat if fields["north"] == "N" else -lat,
        lon if fields["east"] == "E" else -lon,
        int(fields["quality"]),
        strict_number(fields["hdop"]),
    )


def _accuracy(fields: Mapping[str, str]) -> Accuracy | None:
    if not fields["lat"] or not fields["lon"]:
        return None
    sigma = math.hypot(strict_number(fields["lat"]), strict_number(fields["lon"])) / math.sqrt(2.0)
    return Accuracy(_utc(fields), sigma)


def _degrees(fields: Mapping[str, str], axis: str) -> float:
    minutes = strict_number(fields[f"{axis}_min"])
    if minutes >= 60.0:
        raise ValueError("no such angle")
    return strict_number(fields[f"{axis}_deg"]) + minutes / 60.0


def _utc(fields: Mapping[str, str]) -> float:
    hour, minute, second = (strict_number(fields[name]) for name in ("hour", "minute", "second"))
    if hour >= 24.0 or minute >= 60.0 or second >= 61.0:  # a leap second is one
        raise ValueError("no such time")
    return 3600.0 * hour + 60.0 * minute + second
