"""Motion of a base on four mecanum wheels with errors."""

from __future__ import annotations

import math

import numpy as np

from handcart.backends.capabilities.base import WheelTravel
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.simulation.noise.keyed_noise import keyed, keyed_normal
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.numerics.arrays import FloatArray

SIDEWAYS_SIGNS = np.array([-1.0, 1.0, 1.0, -1.0])
"""Signs of the wheels' travel when the base drives to the left: front left and right, rear left and right."""
TURN_SIGNS = np.array([-1.0, 1.0, -1.0, 1.0])


class MecanumWheels:
    """Model of the true motion of a base with four mecanum wheels, by the wheels' travel.

    The true radii, lever arm and slip of the wheels are drawn about the values of the robot's file, with the
    sigmas of its section `errors`. The wheels' errors are independent, so a base that drives sideways also
    turns and drifts ahead (Muir and Neuman 1987, eqs. 31 to 33). Compliant rollers make the sideways travel
    longer or shorter.
    """

    def __init__(self, robot: RobotFile, seed: int) -> None:
        """Draw the errors that stay the same for a run."""
        self._seed, errors = seed, robot.errors
        *radii, arm, sideways = keyed(seed, "mecanum wheels").standard_normal(6)
        self._scales = 1.0 + errors.wheel_radius_percent / 100 * np.array(radii)
        self._arm = 0.5 * robot.drive.tread_m
        self._true_arm = self._arm * (1.0 + errors.tread_percent / 100 * arm)
        self._sideways = 1.0 + errors.sideways_percent / 100 * float(sideways)
        self._slip = errors.slip_percent / 100

    def motion(self, way: WheelTravel, period: int) -> Pose2:
        """Return the base's pose at the end of a period in the base frame at its start, without obstacles.

        Args:
            way: travel of the wheels in the period by their encoders, in [m].
            period: number of the period, which decides the slip.
        """
        if not any(way):
            return Pose2(0.0, 0.0, 0.0)
        ahead, left, turn = self.twist(way, period).tolist()
        half = 0.5 * turn
        chord = math.sin(half) / half if abs(half) > 1e-9 else 1.0
        cos, sin = math.cos(half), math.sin(half)
        return Pose2(chord * (cos * ahead - sin * left), chord * (sin * ahead + cos * left), turn)

    def twist(self, way: WheelTravel, period: int) -> FloatArray:
        """Return the true motion (3,) in a period, in the base frame: travel ahead and to the left in [m],
        and turn to the left in [rad].

        Args:
            way: travel of the wheels in the period by their encoders, in [m].
            period: number of the period, which decides the slip.
        """
        ahead, turned = 0.5 * (way.left + way.right), 0.5 * (way.right - way.left)
        rims = ahead + way.sideways * SIDEWAYS_SIGNS + turned * TURN_SIGNS
        rims *= self._scales * (1.0 - self._slip * keyed_normal(self._seed, "slip", period, 4))
        return np.array(
            [
                rims.mean(),
                self._sideways * (rims @ SIDEWAYS_SIGNS) / 4.0,
                (rims @ TURN_SIGNS) / (4.0 * self._true_arm),
            ]
        )
