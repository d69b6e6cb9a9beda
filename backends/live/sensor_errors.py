"""Errors of the sensors of real robots.

HandcartError ├── InputError │   └── NoSensor        it cannot be opened, or differs from the robot's file
└── RobotFault
    └── StaleSensor     its last reading is too old, or it cannot be read any more
"""

from __future__ import annotations

from handcart.backends.backend import RobotFault
from handcart.files.errors import InputError


class NoSensor(InputError):
    """Error: a sensor cannot be opened, sends no readings, or differs from its part of the robot's file."""


class StaleSensor(RobotFault):
    """Error: a needed sensor delivers no new readings."""

    def __init__(self, sensor: str, age: float | None, allowed: float, why: str = "") -> None:
        status = "no reading has come yet" if age is None else f"its last reading is {1e3 * age:.0f} ms old"
        words = f"{sensor}: {status}; allowed: {1e3 * allowed:.0f} ms"
        super().__init__(f"{words} ({why})" if why else words)
