"""The wheels of a simulated robot that drives in any direction."""

from __future__ import annotations

import numpy as np

from handcart.backends.capabilities.base import WheelTravel
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.physics.engine.engine import GRAVITY_M_S2
from handcart.backends.physics.engine.surface import CASTER_SURFACE
from handcart.backends.simulation.body.mecanum_wheels import MecanumWheels
from handcart.backends.simulation.body.simulated_parts import CommandedHolonomicBase

from .robot_body import RobotBody
from .wheel_drives import WheelDrives

ROLLER_FRICTION = 0.6
"""Coulomb's coefficient between rollers and floor: nothing pushes the base with more than this share of its
weight.
"""


class PhysicsHolonomicBase(CommandedHolonomicBase):
    """Base in a physics engine that drives in any direction, such as on mecanum wheels.

    The base slides without friction on the floor, and a simulated planar drive pushes it in x, y and heading.
    The wheels turn as commanded, but do not move the base.
    """

    def __init__(self, robot: RobotFile, body: RobotBody, chunk: float, seed: int) -> None:
        """Take the wheels over.

        Args:
            robot: robot file.
            body: the robot in an engine.
            chunk: time between two actions of the drives, in [s].
            seed: seed of the wheels' errors.
        """
        super().__init__(robot)
        wheels = body.wheels.all
        self._sides = np.repeat([-1.0, 1.0], [len(body.wheels.left), len(body.wheels.right)])
        self.drives = WheelDrives(body, chunk, wheels)
        body.cover(body.rolling, CASTER_SURFACE)
        self._planar = body.planar_drive()
        force = ROLLER_FRICTION * GRAVITY_M_S2 * sum(map(body.mass, body.link_index))
        self._most = force, 0.5 * force * robot.drive.tread_m
        self._errors = MecanumWheels(robot, seed)
        self._given, self._periods = 0.0, 0

    def begin(self, period: int) -> None:
        """Start the motion of a period, in the direction and at the speed of the base's last command.

        Args:
            period: number of the period.
        """
        speed, turn_rate, sideways = self._take_command()
        half = turn_rate * self._drive.tread_m / 2
        rims = (speed - half, speed + half, sideways)
        way = WheelTravel(*(rate * self._period for rate in rims))
        twist = self._errors.twist(way, period) if any(way) else np.zeros(3)
        twist[2] += self._given
        self._given = 0.0
        self._planar.limit(*self._most)
        self._planar.drive(twist / self._period)
        self._travel = WheelTravel(*(sum(pair) for pair in zip(self._travel, way, strict=True)))
        self.drives.speeds = (speed + half * self._sides) / self._drive.wheel_radius_m

    def give(self, turn: float) -> None:
        """Turn the base, which is at rest, by an angle to the left, in [rad], during the next control period
        of the simulation. The encoders of its wheels do not measure this turn.
        """
        self._given += turn

    def act(self) -> None:
        """Turn the simulated wheels at the commanded speeds; called for each part of a control period.

        This changes only the wheels' angles: the planar drive moves the base, and the encoders follow the
        commands.
        """
        self.drives.follow()

    def read(self) -> None:
        """Do nothing, because the simulated encoders follow the commands exactly."""

    def rezero(self) -> None:
        """Reset to 0 the travel that the wheels' encoders report."""
        self._travel = WheelTravel(0.0, 0.0)
        self.drives.rezero()
