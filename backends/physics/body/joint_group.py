"""Joints that are driven together."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]


class JointGroup(ABC):
    """Some joints of the robot in an engine. What they are told counts until they are told otherwise."""

    @abstractmethod
    def states(self) -> tuple[Vector, Vector]:
        """Positions and velocities (n,), in [rad] or [m] and a second."""

    @abstractmethod
    def turn(self, speeds: Vector, most: Vector) -> None:
        """Bring them to speeds (n,) in [rad/s] or [m/s] by torques of at most `most` (n,) in [Nm] or [N]."""

    @abstractmethod
    def stand(self, positions: Vector, most: Vector, share: float) -> None:
        """Bring them to positions (n,) with at most `most`; in a step of the solver by `share` of the way."""

    def spring(self, stiffness: float, damping: Vector, torques: Vector) -> None:
        """Put springs in [Nm/rad], dampers (n,) in [Nms/rad] and torques (n,) on them for the next chunk."""
        angles, speeds = self.states()
        self.push(torques - stiffness * angles - damping * speeds)

    @abstractmethod
    def push(self, torques: Vector) -> None:
        """Put torques (n,) on them for the next chunk, besides what their drives do, in [Nm] or [N]."""
