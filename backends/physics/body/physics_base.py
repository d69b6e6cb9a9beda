"""The wheels of the simulated robot."""

from __future__ import annotations

import numpy as np

from handcart.backends.capabilities.base import WheelTravel
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.physics.engine.surface import SCRUBBING_SURFACE
from handcart.backends.simulation.body.simulated_parts import CommandedBase
from handcart.backends.simulation.noise.keyed_noise import keyed

from .robot_body import RobotBody
from .wheel_drives import WheelDrives


class PhysicsBase(CommandedBase):
    """Base in a physics engine, on driven wheels that roll and slip on a floor.

    All wheels of one side turn at the same speed.
    """

    def __init__(self, robot: RobotFile, body: RobotBody, chunk: float, seed: int) -> None:
        """Take the driven wheels over; other links must slide on the floor.

        Args:
            robot: robot file.
            body: the robot in an engine.
            chunk: time between two actions of the drives, in [s].
            seed: seed of the wheels' errors.
        """
        super().__init__(robot)
        errors = robot.errors
        left, right, tread = keyed(seed, "wheels").standard_normal(3)
        wheels = body.wheels
        self._lefts = len(wheels.left)
        self._right = np.repeat([False, True], [len(wheels.left), len(wheels.right)])
        """Mask (n,) of the wheels that are on the right side."""
        self._scale = 1.0 + errors.wheel_radius_percent / 100 * np.where(self._right, right, left)
        self._tread_scale = 1.0 + errors.tread_percent / 100 * float(tread)
        self.drives = WheelDrives(body, chunk, wheels.all)
        if len(wheels.all) > 2:
            body.cover(wheels.all, SCRUBBING_SURFACE)

    def begin(self, period: int) -> None:
        """Start the motion of the control period number `period`, by the base's last command."""
        speed, turn_rate, _ = self._take_command()
        half = turn_rate / self._tread_scale * self._drive.tread_m / 2
        rims = np.where(self._right, speed + half, speed - half)
        self.drives.speeds = rims * self._scale / self._drive.wheel_radius_m

    def give(self, turn: float) -> None:
        """Turn the wheels so that the base, which is at rest, turns by an angle to the left, in [rad]. The
        encoders do not count this turn.

        This simulates tyres that yield when the arm swings.
        """
        rim = turn * self._drive.tread_m / 2 / self._drive.wheel_radius_m
        self.drives.give(np.where(self._right, rim, -rim))

    def act(self) -> None:
        """Command the wheels' drives for the next part of the control period."""
        self.drives.follow()

    def read(self) -> None:
        """Update the wheels' travel from the encoders, at the end of a period.

        The engine's wheels have the tread of the robot's file. If the true tread differs from it, the
        difference between the encoders of both sides is scaled.
        """
        travel = self.drives.turned(self._scale) * self._drive.wheel_radius_m
        lefts, wheels = self._lefts, len(travel)
        left, right = sum(travel[:lefts]) / lefts, sum(travel[lefts:]) / (wheels - lefts)
        middle, half = (left + right) / 2, self._tread_scale * (right - left) / 2
        self._travel = WheelTravel(float(middle - half), float(middle + half))

    def rezero(self) -> None:
        """Restart the wheels' travel at 0 from their present angles."""
        self.drives.rezero()
        self.read()
