"""Stubs of a robot's sensors, and localizations made of them."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from handcart.backends.backend import Backend
from handcart.backends.capabilities.base import Base, DriveCommand, WheelTravel
from handcart.backends.capabilities.beacons import BeaconRanges, Beacons
from handcart.backends.capabilities.capability import Capability
from handcart.backends.capabilities.gps import Fix, Gps
from handcart.backends.capabilities.imu import Imu
from handcart.backends.capabilities.positioning import PoseReading, Positioning
from handcart.backends.capabilities.range_sensor import RangeSensor, Scan
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.robot.localization.localization import Localization
from handcart.backends.robot.localization.localizations import localization_of
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.maps.grid_map import GridMap

START = Pose2(2.0, 3.0, 0.5)
GRAVITY = np.array([0.0, 0.0, 9.81])
STANDS = DriveCommand()
START_VARIANCES = [0.05**2, 0.05**2, 0.035**2]


class Wheels(Base):
    def __init__(self) -> None:
        self.travel = WheelTravel(0.0, 0.0)

    def drive(self, speed: float, turn_rate: float) -> None:
        raise AssertionError("a localization commands nothing")

    def wheel_travel(self) -> WheelTravel:
        return self.travel

    def roll(self, left: float, right: float) -> None:
        self.travel = WheelTravel(self.travel.left + left, self.travel.right + right)


class Gyros(Imu):
    """A sensor whose noise makes each reading another; not while it is `stuck`."""

    def __init__(self) -> None:
        self.asked, self.stuck, self.broken = 0, False, False

    def rates(self) -> np.ndarray:
        self.asked += not self.stuck
        return np.array([0.0, 0.0, math.nan if self.broken else 1e-6 * self.asked])

    def accelerations(self) -> np.ndarray:
        return GRAVITY


class Receiver(Gps):
    def __init__(self) -> None:
        self.now: Fix | None = None

    def fix(self) -> Fix | None:
        return self.now


class Radio(Beacons):
    def __init__(self) -> None:
        self.now: BeaconRanges | None = None

    def ranges(self) -> BeaconRanges | None:
        return self.now


class Ceiling(Positioning):
    def __init__(self) -> None:
        self.now: PoseReading | None = None

    def reading(self) -> PoseReading | None:
        return self.now


class Room(RangeSensor):
    """A lidar in the middle of a room of 8 m by 6 m, of a base at `pose` in it."""

    def __init__(self) -> None:
        self.pose, self.count = START, 0

    def scan(self) -> Scan:
        angles = np.linspace(-math.pi, math.pi, 180, endpoint=False)
        heading = angles + self.pose.theta
        self.count += 1
        with np.errstate(divide="ignore"):
            across = np.where(np.cos(heading) > 0.0, 8.0 - self.pose.x, -self.pose.x) / np.cos(heading)
            along = np.where(np.sin(heading) > 0.0, 6.0 - self.pose.y, -self.pose.y) / np.sin(heading)
        jitter = 1e-6 * (self.count % 7)
        return Scan(angles, np.minimum(across, along) + jitter, Pose2(0.0, 0.0, 0.0))


class Stub(Backend):
    """A backend with some capabilities and constant time."""

    name, period = "stub", 0.05

    def __init__(self, *parts: Capability) -> None:
        self._parts = parts

    @classmethod
    def build(cls, robot: RobotFile, world: Path | None, seed: int) -> Backend:
        raise NotImplementedError

    def capabilities(self) -> tuple[Capability, ...]:
        return self._parts

    def step(self) -> None:
        pass

    def stop(self) -> None:
        pass

    def close(self) -> None:
        pass


def room() -> GridMap:
    solid = np.zeros((140, 180), np.bool_)
    solid[:10], solid[130:], solid[:, :10], solid[:, 170:] = True, True, True, True
    return GridMap(solid, np.zeros_like(solid), 0.05, -0.5, -0.5)


def made(name: str, localizer: str, *parts: Capability, grid: GridMap | None = None) -> Localization:
    backend = Stub(*parts)
    spec = load_robot(name).model_copy(update={"localizer": localizer})
    return localization_of(backend, spec, START, grid, backend.get(RangeSensor))  # type: ignore[type-abstract]
