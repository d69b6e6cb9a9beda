"""Joints that are driven together."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np

from handcart.robotics.numerics.arrays import FloatArray

FULL_TORQUE_ERROR_RAD = 0.03  # off its set-point by this, a drive that gives has all its torque [rad]
SPEED_ERROR_TIME_S = 0.03  # a speed that is off counts as this much angle that is off [s]
MIN_TORQUE_RATIO = 0.03  # share of its torque that such a drive always has to give


class JointGroup(ABC):
    """Some joints of the robot in an engine. A command holds until the next one.

    Positions are in [rad] or [m], speeds the same a second, torques in [Nm] or [N]; all are arrays (n,).
    """

    @abstractmethod
    def states(self) -> tuple[FloatArray, FloatArray]:
        """Positions and velocities."""

    @abstractmethod
    def turn(self, speeds: FloatArray, most: FloatArray) -> None:
        """Bring them to speeds by torques of at most `most`."""

    def follow(self, off: FloatArray, rates: FloatArray, most: FloatArray, catches_up: float) -> None:
        """Follow set-points for the next chunk by torques of at most `most`.

        Args:
            off: of the set-points, ahead of where the joints are now.
            rates: at which they move.
            most: of the torques.
            catches_up: time constant in which what is off gets less, in [s].
        """
        self.turn(rates + off / catches_up, most)

    def give(
        self, off: FloatArray, rates: FloatArray, effort: FloatArray, fastest: FloatArray, catches_up: float
    ) -> None:
        """Follow as `follow` does, but yield like springs at an obstacle.

        The torque is limited by a joint's distance from its set-point, which is `GIVES` at the full
        `effort`.

        Args:
            off: distance of the set-points from the current joints.
            rates: rates of the set-points.
            effort: maximum effort of the drives.
            fastest: maximum speeds of catching up.
            catches_up: time constant of catching up, in [s].
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
        """Bring them to positions with at most `most`; in a step of the solver by `share` of the way.

        An engine without chunks has the set-points move at `rates`: they are there when the period ends.
        """

    def spring(self, stiffness: float, damping: FloatArray, torques: FloatArray) -> None:
        """Put springs in [Nm/rad], dampers in [Nms/rad] and torques on them for the next chunk."""
        angles, speeds = self.states()
        self.push(torques - stiffness * angles - damping * speeds)

    @abstractmethod
    def push(self, torques: FloatArray) -> None:
        """Put torques on them for the next chunk, besides what their drives do."""
