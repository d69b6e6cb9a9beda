"""The wheels of a kinematic robot that drives in any direction."""

from __future__ import annotations

from handcart.backends.capabilities.base import WheelTravel
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.simulation.body.mecanum_wheels import MecanumWheels
from handcart.backends.simulation.body.simulated_parts import CommandedHolonomicBase
from handcart.robotics.geometry.pose2 import Pose2


class KinematicHolonomicBase(CommandedHolonomicBase):
    """Simulated base that drives in any direction, without dynamics.

    Its wheels turn as commanded; `MecanumWheels` computes the true motion of the base.
    """

    def __init__(self, robot: RobotFile, seed: int) -> None:
        super().__init__(robot)
        self._wheels = MecanumWheels(robot, seed)

    def advance(self, period: int) -> Pose2:
        """Turn the wheels for a period, and return the motion of the base as if there were no obstacles.

        Args:
            period: number of the period.

        Returns:
            Pose of the base at the end of the period in the base frame at its start.
        """
        speed, turn_rate, sideways = self._take_command()
        half = turn_rate * self._drive.tread_m / 2
        left, right = (speed - half) * self._period, (speed + half) * self._period
        way = WheelTravel(left, right, sideways * self._period)
        self._travel = WheelTravel(*(sum(pair) for pair in zip(self._travel, way, strict=True)))
        return self._wheels.motion(way, period)
