"""Sensors beside the drives of a real robot: the key `sensors` of the section `can` of its file."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from handcart.files.models.model import FileModel

Port = Annotated[str, Field(min_length=1, max_length=200)]
"""A serial port such as /dev/ttyUSB0, or `socket://HOST:PORT`."""
Baud = Annotated[int, Field(ge=1200, le=4_000_000)]
Stale = Annotated[float, Field(gt=0.0, le=10_000.0)]
"""Age in [ms] beyond which a reading is stale."""


class CameraSource(FileModel):
    """Source of a camera's pictures (device, URL or file), read by OpenCV's VideoCapture."""

    source: Annotated[int, Field(ge=0, le=99)] | Annotated[str, Field(min_length=1, max_length=500)]
    """A device's number, a URL, or a file with a video or a picture."""
    stale_ms: Stale = 200.0


class LineSource(FileModel):
    """Port of a lidar or IMU that sends its readings by the line protocol of docs/how_to/hardware.md."""

    port: Port
    baud: Baud = 115_200
    stale_ms: Stale = 200.0


class GpsSource(FileModel):
    """Port and accuracy of a satellite receiver that sends NMEA 0183 sentences."""

    port: Port
    baud: Baud = 9600
    stale_ms: Stale = 2000.0
    origin_lat_deg: Annotated[float, Field(ge=-89.0, le=89.0)]
    """Latitude of the task's origin, north positive (WGS 84)."""
    origin_lon_deg: Annotated[float, Field(ge=-180.0, le=180.0)]
    """Longitude of the task's origin, east positive (WGS 84)."""
    sigma_m: Annotated[float, Field(gt=0.0, le=100.0)] = 2.5
    """Sigma of a fix with an HDOP of 1, on each axis, if the receiver sends no GST."""
    quality: Literal[1, 2, 3, 4, 5] = 1
    """Minimum quality of a fix. From worst to best: 1 single, 3 PPS, 2 differential, 5 RTK float, 4 RTK
    fixed.

    Estimated positions (6), manual input (7) and simulation (8) are never fixes.
    """


class SensorsSpec(FileModel):
    """Connections of the sensors that are not on the CAN bus (key `sensors` of the section `can`).

    What the sensors measure is described in the robot file's sections `camera`, `gps` and others.
    """

    camera: CameraSource | None = None
    range_sensor: LineSource | None = None
    imu: LineSource | None = None
    gps: GpsSource | None = None
