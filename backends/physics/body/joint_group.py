"""Joints that are driven together."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np

from handcart.robotics.numerics.arrays import FloatArray

FULL_TORQUE_ERROR_RAD = 0.03  # off its set-point by this, a drive that gives has all its torque [rad]
SPEED_ERROR_TIME_S = 0.03  # a speed that is off counts as this much angle that is off [s]
MIN_TORQUE_RATIO = 0.03  # share of its torque that such a drive always has to give


class JointGroup(ABC):
    """A group of the robot's joints in a physics engine, whose positions are read and whose drives are
    commanded.

    A command to the drives holds until the next one. The time between two commands is a control period or a
    part of it (a chunk, see `Engine.chunk`). Arrays (n,) are in the order in which the joints were selected;
    units are [rad] for turning joints, [m] for sliding joints.
    """

    @abstractmethod
    def states(self) -> tuple[FloatArray, FloatArray]:
        """Return positions (n,) in [rad] or [m], and velocities (n,) in [rad/s] or [m/s]."""

    @abstractmethod
    def turn(self, speeds: FloatArray, most: FloatArray) -> None:
        """Drive the joints at given speeds, with limited efforts.

        Args:
            speeds: (n,) in [rad/s] or [m/s].
            most: (n,) largest efforts, in [Nm] or [N].
        """

    def follow(self, off: FloatArray, rates: FloatArray, most: FloatArray, catches_up: float) -> None:
        """Follow moving set-points until the next command, with limited efforts.

        Args:
            off: (n,) set-points minus present joints, in [rad] or [m].
            rates: (n,) rates of the set-points, in [rad/s] or [m/s].
            most: (n,) largest efforts, in [Nm] or [N].
            catches_up: time constant with which `off` decreases, in [s].
        """
        self.turn(rates + off / catches_up, most)

    def give(
        self, off: FloatArray, rates: FloatArray, effort: FloatArray, fastest: FloatArray, catches_up: float
    ) -> None:
        """Follow moving set-points until the next command, but yield like springs at an obstacle.

        The effort grows with a joint's distance from its set-point, up to `effort` at the distance
        `FULL_TORQUE_ERROR_RAD`.

        Args:
            off: (n,) set-points minus present joint positions, in [rad] or [m].
            rates: (n,) rates of the set-points, in [rad/s] or [m/s].
            effort: (n,) maximum effort of the drives, in [Nm] or [N].
            fastest: (n,) maximum speeds at which `off` decreases, in [rad/s] or [m/s].
            catches_up: time constant with which `off` decreases, in [s].
        """
        wanted = np.clip(rates + off / catches_up, -fastest, fastest)
        strain = np.abs(off + SPEED_ERROR_TIME_S * (rates - self.states()[1]))
        self.turn(
            wanted, effort * np.minimum(strain / FULL_TORQUE_ERROR_RAD + MIN_TORQUE_RATIO, 1.0)
        )  # never negative

    @abstractmethod
    def stand(
        self, positions: FloatArray, most: FloatArray, share: float, rates: FloatArray | None = None
    ) -> None:
        """Move the joints to positions and hold them there.

        Args:
            positions: (n,) in [rad] or [m].
            most: (n,) largest efforts, in [Nm] or [N].
            share: share of the remaining distance, 0 to 1, that is corrected in one step of the solver.
            rates: (n,) rates of the set-points in [rad/s] or [m/s]. An engine that commands its drives once a
                period moves the set-points at these rates, so that they reach `positions` at the period's
                end.
        """

    def spring(self, stiffness: float, damping: FloatArray, torques: FloatArray) -> None:
        """Apply springs, dampers and torques to the joints until the next command.

        Args:
            stiffness: stiffness of the springs, in [Nm/rad] or [N/m]; their torque is zero at joint position
                0.
            damping: (n,) coefficients of the dampers, in [Nms/rad] or [Ns/m].
            torques: (n,) constant torques, in [Nm] or [N].
        """
        angles, speeds = self.states()
        self.push(torques - stiffness * angles - damping * speeds)

    @abstractmethod
    def push(self, torques: FloatArray) -> None:
        """Apply torques (n,), in [Nm] or [N], in addition to those of the drives, until the next command."""
