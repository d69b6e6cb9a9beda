"""Errors of a robot: missing sensors, and readings that are not new.

HandcartError
├── MissingSensor (ValueError)
├── NoSidewaysDrive (ValueError)
├── UnknownStart (ValueError)
└── StaleReading (RuntimeError)
"""

from __future__ import annotations

from handcart.backends.backend import Backend
from handcart.backends.description.robot_file import RobotFile
from handcart.files.errors import HandcartError
from handcart.files.suggest import suggest


class MissingSensor(HandcartError, ValueError):
    """Error: the robot has no sensor of the requested name."""

    exit_status = 2

    def __init__(self, name: str, spec: RobotFile) -> None:
        wrong = "the backend does not provide" if name in spec.sensors else "the robot's file has no"
        super().__init__(f"{wrong} sensor {name!r}{suggest(name, spec.sensors)}")


class NoSidewaysDrive(HandcartError, ValueError):
    """Error: the robot's file has a holonomic drive, but the backend cannot drive sideways."""

    exit_status = 2

    def __init__(self, backend: Backend) -> None:
        words = "drives no holonomic base; allowed: a backend whose base is a HolonomicBase"
        super().__init__(f"the backend {backend.name!r} {words}: kinematic, mujoco")


class UnknownStart(HandcartError, ValueError):
    """Error: the initial pose is unknown, and the robot cannot find it by scans."""

    exit_status = 2

    def __init__(self, spec: RobotFile) -> None:
        needed = "a map, a lidar, and the localizer scan or odometry"
        super().__init__(f"the start is unknown, and the localizer is {spec.localizer}; needed: {needed}")


class StaleReading(HandcartError, RuntimeError):
    """Error: a sensor delivers an old reading again as if it were new."""
