"""The drives of wheels, and their encoders."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import ClassVar

import numpy as np

from handcart.backends.physics.engine.surface import TYRE_SURFACE
from handcart.robotics.numerics.arrays import FloatArray

from .robot_body import RobotBody

COUNTS_PER_TURN = 65536  # of an encoder, a turn
CATCHES_UP = 0.02  # time constant of the drives' position loop [s]
MOST_LAG = 0.05  # that a blocked wheel makes up for later [rad]


class WheelDrives:
    """Velocity drives and encoders of the wheels in a physics engine.

    The drives control the wheels' angles, so that a wheel that lags catches up. The encoders' readings are
    rounded to whole steps.
    """

    STATE: ClassVar = {"speeds": FloatArray, "_goal": FloatArray, "_first": FloatArray, "_given": FloatArray}

    def __init__(self, body: RobotBody, chunk: float, names: Sequence[str]) -> None:
        """Take over the wheels at these joints; they rub on the floor as tyres do.

        Args:
            body: the robot in an engine.
            chunk: time between two actions of the drives, in [s].
            names: names of the wheels' joints.
        """
        self._chunk, self._joints = chunk, body.joints(names)
        self._most = np.array([body.effort[name] for name in names])
        body.cover(names, TYRE_SURFACE)
        self.speeds = np.zeros(len(names))
        """Wanted speeds (n,) of the wheels in this period, in [rad/s]."""
        self._first = self._goal = self._angles()
        self._given = np.zeros(len(names))

    def give(self, rolled: FloatArray) -> None:
        """Turn the wheels by angles (n,) in [rad], positive forwards, without the encoders counting this
        turn.
        """
        self._given = self._given + rolled
        self._goal = self._goal + rolled

    def follow(self) -> None:
        """Command the drives to turn the wheels at the wanted `speeds` until the next call in a control
        period.
        """
        angles = self._angles()
        lag = np.minimum(np.maximum(self._goal - angles, -MOST_LAG), MOST_LAG)
        self._goal = angles + lag + self.speeds * self._chunk
        self._joints.follow(lag, self.speeds, self._most, CATCHES_UP)

    def turned(self, scale: FloatArray | float = 1.0) -> FloatArray:
        """Return the angles (n,) by which the wheels have turned since `rezero`, in [rad], rounded to the
        encoders' steps.

        Args:
            scale: (n,) or one for all: true radius of the wheels divided by the radius in the robot's file.
        """
        turned = (self._angles() - self._given - self._first) / scale
        return np.asarray(
            np.round(turned * (COUNTS_PER_TURN / (2 * math.pi))) * (2 * math.pi / COUNTS_PER_TURN)
        )

    def rezero(self) -> None:
        """Set the encoders to 0 at the wheels' present angles."""
        self._first = self._angles() - self._given

    def _angles(self) -> FloatArray:
        return np.asarray(self._joints.states()[0])
