"""Slip of a held thing under more force than the grip bears."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from handcart.backends.physics.engine.engine import Pinned
from handcart.robotics.geometry.transform import Transform, inverse
from handcart.robotics.numerics.arrays import FloatArray

from .mujoco_module import mujoco
from .pins import Pins

STICKING_SPEED_M_S = 0.005  # [m/s]: an object that slid in the hand is held again below this speed


class Slipping:
    """Model of friction between fingers and a held thing.

    Pins (`Pins`) fix the thing to the hand. They are released while the thing is pulled harder than friction
    holds it, so that it slips.
    """

    def __init__(self, pins: Pins, contacts_carry: float, period: float) -> None:
        """Prepare slipping with the share `Engine.CONTACTS_CARRY`.

        Args:
            pins: equalities that hold the thing.
            contacts_carry: share of the pads' friction that contacts have.
            period: control period, in [s]; a thing that slid more slowly than `STICKING_SPEED_M_S` in it is
                held again.
        """
        self._pins, self._carry, self._stays = pins, contacts_carry, STICKING_SPEED_M_S * period
        self.pinned: Pinned | None = None
        """Rigid connection, slipping or not."""

    def hold(self, model: Any, data: Any, pinned: Pinned, hand: int, other: int) -> None:
        """Fix the hand and the held thing to each other at points.

        Args:
            model: MuJoCo's model.
            data: MuJoCo's data.
            pinned: the points in the frames of both bodies, and the largest force that a point bears.
            hand: MuJoCo's number of the hand's body.
            other: MuJoCo's number of the held thing's body.
        """
        self.pinned = pinned
        self._pins.close(model, data, pinned, hand, other)

    def let_go(self, data: Any) -> None:
        """Release the held thing, by deactivating the pins (constraints) in MuJoCo's `data`."""
        self.pinned = None
        self._pins.open(data)

    def look(self, model: Any, data: Any, hand: int, other: int) -> None:
        """Release or fix the held thing after a step of the solver.

        The held thing slips if it is pulled harder than friction allows. It is fixed to the hand again when
        it moves more slowly in the hand than `STICKING_SPEED_M_S`.

        Args:
            model: MuJoCo's model.
            data: MuJoCo's data.
            hand: MuJoCo's number of the hand's body.
            other: MuJoCo's number of the held thing's body.
        """
        pinned = self.pinned
        assert pinned is not None
        if self._pins.closed(data):
            # While the pins hold, contacts carry almost nothing: the pins alone carry an object at rest.
            if self._pins.pull(data) > pinned.force_n / (1.0 - self._carry):
                self._pins.open(data)
            return
        mujoco().mj_kinematics(model, data)
        there = _points(data, pinned, hand, other)
        slid = float(np.linalg.norm(there - np.array(pinned.other_points), axis=1).max())
        points = tuple((float(x), float(y), float(z)) for x, y, z in there)
        self.pinned = replace(pinned, other_points=points)
        if slid < self._stays:
            self.hold(model, data, self.pinned, hand, other)


def _points(data: Any, pinned: Pinned, hand: int, other: int) -> FloatArray:
    """Return the points of `pinned.points`, which are fixed in the hand, in the frame of the held thing, (n,
    3) in [m].
    """
    world_T_hand = _pose(data.xipos[hand], data.ximat[hand])
    other_T_hand = inverse(_pose(data.xpos[other], data.xmat[other])) @ world_T_hand
    return np.asarray(np.array(pinned.points) @ other_T_hand[:3, :3].T + other_T_hand[:3, 3])


def _pose(position: FloatArray, turn: FloatArray) -> Transform:
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = turn.reshape(3, 3), position
    return pose
