"""Points at which two bodies are held together."""

from __future__ import annotations

from typing import Any

import numpy as np

from handcart.backends.physics.engine import Pinned

from .mujoco_module import mujoco
from .world_spec import STIFF

MOST = 4  # points
_NAME = "pin {}"


class Pins:
    """Equalities between the hand and what it holds; which thing that is changes while the world goes on."""

    def __init__(self) -> None:
        """There are none yet."""
        self._there = False

    def prepare(self, spec: Any, hand: str, other: str) -> None:
        """Have them in the model, open; `other` is some other body."""
        kinds, what = mujoco().mjtEq, mujoco().mjtObj
        for number in range(MOST):
            pin = spec.add_equality(name=_NAME.format(number), name1=hand, name2=other, active=False)
            pin.type, pin.objtype, pin.solref = kinds.mjEQ_CONNECT, what.mjOBJ_BODY, STIFF
        self._there = True

    def closed(self, model: Any, data: Any) -> bool:
        """Whether they hold something."""
        return bool(data.eq_active[_first(model)])

    def pull(self, model: Any, data: Any) -> float:
        """What a point bears, on the mean over all, in [N]."""
        # MuJoCo has equalities before all else that constrains.
        kinds, numbers = data.efc_type[: data.ne], data.efc_id[: data.ne] - _first(model)
        mine = (kinds == mujoco().mjtConstraint.mjCNSTR_EQUALITY) & (numbers >= 0) & (numbers < MOST)
        return float(np.linalg.norm(data.efc_force[: data.ne][mine].reshape(-1, 3), axis=1).sum()) / MOST

    def open(self, model: Any, data: Any) -> None:
        """Hold nothing."""
        if self._there:
            first = _first(model)
            data.eq_active[first : first + MOST] = 0

    def close(self, model: Any, data: Any, wanted: Pinned, hand: int, other: int) -> None:
        """Hold two of MuJoCo's bodies together."""
        turn = np.zeros(9)
        mujoco().mju_quat2Mat(turn, model.body_iquat[hand])
        for number, (point, there) in enumerate(zip(wanted.points, wanted.other_points, strict=True)):
            pin = _first(model) + number
            model.eq_obj1id[pin], model.eq_obj2id[pin] = hand, other
            model.eq_data[pin, :3] = turn.reshape(3, 3) @ point + model.body_ipos[hand]
            model.eq_data[pin, 3:6] = there
            data.eq_active[pin] = 1


def _first(model: Any) -> int:
    """MuJoCo's number of the first of them; the others follow."""
    return int(model.equality(_NAME.format(0)).id)
