"""Points at which two bodies are held together."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from handcart.backends.physics.engine.engine import Pinned
from handcart.robotics.numerics.arrays import FloatArray

from .mujoco_module import mujoco
from .world_spec import CONTACT_COMPLIANCE

MAX_PIN_POINTS = 4  # points
_NAME = "pin {}"


class Pins:
    """Point constraints of MuJoCo (pins) that fix whatever thing is held at present to the hand.

    In the model, the pins come after the equality constraints that couple joints to others (mimic joints).
    """

    def __init__(self) -> None:
        """Begin without pins."""
        self._there, self._first = False, 0

    def prepare(self, spec: Any, hand: str, other: str) -> None:
        """Add pins (constraints that can fix a held thing to the hand) to the `MjSpec` of a world. They are
        inactive until `close` is called.

        Args:
            spec: the `MjSpec`.
            hand: name of the hand's body.
            other: name of any other body, a placeholder until something is held.
        """
        kinds, what = mujoco().mjtEq, mujoco().mjtObj
        self._first = len(spec.equalities)
        assert all(equality.type == kinds.mjEQ_JOINT for equality in spec.equalities)
        for number in range(MAX_PIN_POINTS):
            pin = spec.add_equality(name=_NAME.format(number), name1=hand, name2=other, active=False)
            pin.type, pin.objtype, pin.solref = kinds.mjEQ_CONNECT, what.mjOBJ_BODY, CONTACT_COMPLIANCE
        self._there = True

    def closed(self, data: Any) -> bool:
        """Return True if the pins (constraints of MuJoCo) are active, so that they fix a thing to the
        hand.
        """
        return bool(data.eq_active[self._first])

    def pull(self, data: Any) -> float:
        """Return the force, in [N], that a point constraint (pin) between hand and held thing exerts, as the
        mean over the `MAX_PIN_POINTS` pins. It is valid only while the pins are active (`closed`).
        """
        forces = data.efc_force[self._first : self._first + 3 * MAX_PIN_POINTS].tolist()
        return (
            sum(math.hypot(*forces[row : row + 3]) for row in range(0, 3 * MAX_PIN_POINTS, 3))
            / MAX_PIN_POINTS
        )

    def force(self, data: Any) -> FloatArray:
        """Return the force (3,) that the held thing exerts on the hand through the pins, in the world frame,
        in [N]; zero if nothing is held.
        """
        if not self._there or not self.closed(data):
            return np.zeros(3)
        rows = data.efc_force[self._first : self._first + 3 * MAX_PIN_POINTS]
        return np.asarray(rows.reshape(-1, 3).sum(axis=0))

    def open(self, data: Any) -> None:
        """Release the held thing, by deactivating the pins (constraints) in MuJoCo's `data`."""
        if self._there:
            data.eq_active[self._first : self._first + MAX_PIN_POINTS] = 0

    def close(self, model: Any, data: Any, wanted: Pinned, hand: int, other: int) -> None:
        """Activate the point constraints (pins) that hold the hand and a thing together at the points of
        `wanted`.

        Args:
            model: MuJoCo's model.
            data: MuJoCo's data.
            wanted: points in the frames of both bodies.
            hand: MuJoCo's number of the hand's body.
            other: MuJoCo's number of the held thing's body.

        Raises:
            ValueError: there are not `MAX_PIN_POINTS` points; `pull` and `force` would read other
                constraints.
        """
        if len(wanted.points) != MAX_PIN_POINTS:
            raise ValueError(f"{len(wanted.points)} points hold a thing; needed: {MAX_PIN_POINTS}")
        self.aim(model, wanted, hand, other)
        data.eq_active[self._first : self._first + MAX_PIN_POINTS] = 1

    def aim(self, model: Any, wanted: Pinned, hand: int, other: int) -> None:
        """Set the bodies and points of the pins (constraints) in MuJoCo's `model`, active or not.

        A model that is compiled again has the placeholders of `prepare` instead.

        Args:
            model: MuJoCo's model.
            wanted: points in the frames of both bodies.
            hand: MuJoCo's number of the hand's body.
            other: MuJoCo's number of the held thing's body.
        """
        turn = np.zeros(9)
        mujoco().mju_quat2Mat(turn, model.body_iquat[hand])
        for item, (point, there) in enumerate(zip(wanted.points, wanted.other_points, strict=True)):
            number = self._first + item
            model.eq_obj1id[number], model.eq_obj2id[number] = hand, other
            model.eq_data[number, :3] = turn.reshape(3, 3) @ point + model.body_ipos[hand]
            model.eq_data[number, 3:6] = there
