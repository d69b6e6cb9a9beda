"""All kinds of capabilities."""

from __future__ import annotations

from .arm import Arm
from .base import Base
from .beacons import Beacons
from .camera import Camera
from .capability import Capability
from .gps import Gps
from .gripper import Gripper
from .imu import Imu
from .positioning import Positioning
from .range_sensor import RangeSensor

ALL_CAPABILITIES: tuple[type[Capability], ...] = (
    Base,
    RangeSensor,
    Arm,
    Camera,
    Gripper,
    Positioning,
    Imu,
    Gps,
    Beacons,
)
"""The conformance kit tries each of them."""
