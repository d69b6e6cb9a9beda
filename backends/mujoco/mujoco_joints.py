"""Joints of the robot in MuJoCo."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from handcart.backends.physics.body.joint_group import JointGroup, Vector

from .mujoco_engine import MujocoEngine

UNBOUND = 1e6  # [Nm]


class MujocoJoints(JointGroup):
    """See `JointGroup`. A drive is a servo of its speed, in each step of the solver.

    As stiff as it can be: alone, it is at the speed that it is told after a step.
    """

    def __init__(self, engine: MujocoEngine, names: Sequence[str]) -> None:
        """Those of the model by their names."""
        self._engine, model = engine, engine.model
        joints = [model.joint(name) for name in names]
        self._at = _where([int(joint.qposadr[0]) for joint in joints])
        self._speed = _where([int(joint.dofadr[0]) for joint in joints])
        self._drives = _where([int(model.actuator(name).id) for name in names])
        self._step = float(model.opt.timestep)
        self._gain = model.dof_M0[self._speed] / self._step

    def states(self) -> tuple[Vector, Vector]:
        """See `JointGroup`."""
        data = self._engine.data
        return data.qpos[self._at].copy(), data.qvel[self._speed].copy()

    def turn(self, speeds: Vector, most: Vector) -> None:
        """See `JointGroup`."""
        self._serve(speeds, self._gain, np.zeros(len(self._gain)), most)

    def stand(self, positions: Vector, most: Vector, share: float) -> None:
        """See `JointGroup`."""
        pull = self._gain * share / self._step
        self._serve(positions, pull, pull, most)

    def _serve(self, wanted: Vector, gain: Vector, pull: Vector, most: Vector) -> None:
        model, data = self._engine.model, self._engine.data
        data.ctrl[self._drives] = wanted
        model.actuator_gainprm[self._drives, 0] = gain
        model.actuator_biasprm[self._drives, 1] = -pull
        model.actuator_biasprm[self._drives, 2] = -self._gain
        model.actuator_forcerange[self._drives, 0] = -most
        model.actuator_forcerange[self._drives, 1] = most

    def spring(self, stiffness: float, damping: Vector, torques: Vector) -> None:
        """See `JointGroup`; solved implicitly: dampers as strong would shake a chassis in the air."""
        model = self._engine.model
        model.actuator_gainprm[self._drives, 0] = 0.0
        model.actuator_biasprm[self._drives, 0] = torques
        model.actuator_biasprm[self._drives, 1] = -stiffness
        model.actuator_biasprm[self._drives, 2] = -damping
        model.actuator_forcerange[self._drives] = (-UNBOUND, UNBOUND)

    def push(self, torques: Vector) -> None:
        """See `JointGroup`."""
        self._engine.data.qfrc_applied[self._speed] = torques


def _where(numbers: list[int]) -> slice | NDArray[np.int64]:
    """What picks these of an array: a slice, which is quicker, where one follows the other."""
    first = numbers[0] if numbers else 0
    run = slice(first, first + len(numbers))
    return run if numbers == list(range(run.start, run.stop)) else np.array(numbers)
