"""The line protocol of range sensors and inertial units.

    $RANGE,1250,0.512,0.514,,0.52*6A
    $IMU,1250,0.001,0.0,-0.02,0.1,0.0,9.81*54

First is the sensor's own time in [ms]. RANGE: ranges of one scan in [m], from the first beam to the last; an
empty field or `inf` where nothing came back, `-inf` where something is too close, `nan` where a reading is
invalid (REP 117), and zeros where the driver delivers them. IMU: turn rates about x, y, z in [rad/s], then
accelerations along them in [m/s²]. Behind `*` is the exclusive or of all bytes between `$` and `*`, in
hexadecimal, as in NMEA 0183.
"""

from __future__ import annotations

import math
import re
from functools import reduce
from operator import xor
from typing import NamedTuple

import numpy as np

from handcart.robotics.numerics.arrays import FloatArray

from .strict_number import strict_number

_FRAMED = re.compile(rb"\$([^*]*)\*([0-9A-Fa-f]{2})")
_SPECIAL = {"inf": math.inf, "-inf": -math.inf, "nan": math.nan}
_STAMP = re.compile(r"\d{1,15}", re.ASCII)


class SensorLine(NamedTuple):
    """Line of text that a lidar or IMU has sent, parsed into kind, time and values after a check of its
    checksum.
    """

    kind: str
    """RANGE or IMU."""
    stamp: int
    """The sensor's time in [ms]."""
    values: FloatArray
    """Values (n,) of the line, in the units of the line protocol; infinity where a field is empty."""


def checksum(body: bytes) -> int:
    """Return the checksum of a line: the exclusive or of all bytes between `$` and `*`."""
    return reduce(xor, body, 0)


def sensor_line(kind: str, stamp: int, values: FloatArray) -> bytes:
    """Return a line as a sensor sends it, with checksum and line end.

    Args:
        kind: RANGE or IMU.
        stamp: time of the sensor's clock, in [ms].
        values: (n,) ranges in [m], first beam first; or (6,) rates about the base's x, y, z in [rad/s], then
            accelerations along them in [m/s²]; infinity is sent as an empty field.
    """
    fields = ",".join("" if value == math.inf else f"{value:.4f}" for value in values)
    body = f"{kind},{stamp},{fields}".encode()
    return b"$%b*%02X\n" % (body, checksum(body))


def read_line(line: bytes) -> SensorLine | None:
    """Parse a line of a lidar or IMU (`$RANGE` or `$IMU`); return None if it is damaged or of another
    kind.
    """
    try:
        kind, stamp, *fields = body_of(line).decode("ascii").split(",")
        if not _STAMP.fullmatch(stamp):
            return None
        number = _range if kind == "RANGE" else strict_number
        values = np.array([number(field) if field else math.inf for field in fields])
        return SensorLine(kind, int(stamp), values)
    except ValueError:
        return None


def _range(text: str) -> float:
    return _SPECIAL[text] if text in _SPECIAL else strict_number(text)


def body_of(line: bytes) -> bytes:
    """Return the part between `$` and `*` of a line of the sensors' line protocol.

    Raises:
        ValueError: the line is not of the form `$...*XX`, or its checksum XX is wrong.
    """
    framed = _FRAMED.fullmatch(line)
    if framed is None or int(framed.group(2), 16) != checksum(framed.group(1)):
        raise ValueError("damaged")
    return framed.group(1)
