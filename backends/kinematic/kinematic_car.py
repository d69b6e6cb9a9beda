"""The wheels of a kinematic robot that steers like a car."""

from __future__ import annotations

from typing import ClassVar

from handcart.backends.capabilities.base import WheelTravel
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.simulation.body.rough_ride import RoughRide
from handcart.backends.simulation.body.simulated_parts import CommandedBase
from handcart.robotics.geometry.pose2 import Pose2


class KinematicCar(CommandedBase):
    """Simulated base that steers like a car (Ackermann steering), without dynamics.

    The rear wheels reach the commanded speed at once. The front wheels steer, at limited speed, to the
    commanded curvature, which is the turn rate divided by the speed; a standing car keeps its steering. Wheel
    travel is that of the rear wheels.
    """

    STATE: ClassVar = {**CommandedBase.STATE, "_bend": float}

    def __init__(self, robot: RobotFile, ride: RoughRide) -> None:
        super().__init__(robot)
        self._ride = ride
        self._bend = 0.0

    def advance(self, period: int) -> Pose2:
        """Turn the wheels for a period, and return the motion of the base as if there were no obstacles.

        Args:
            period: number of the period.

        Returns:
            Pose of the base at the end of the period in the base frame at its start.
        """
        speed, turn_rate, _ = self._take_command()
        if speed != 0.0:
            most = self._drive.steering_per_m_s * self._period
            self._bend += max(-most, min(most, turn_rate / speed - self._bend))
        rolled, half = speed * self._period, 0.5 * self._bend * self._drive.tread_m
        left, right, _ = self._travel
        self._travel = WheelTravel(left + rolled * (1.0 - half), right + rolled * (1.0 + half))
        return self._ride.motion(rolled, self._bend, period)
