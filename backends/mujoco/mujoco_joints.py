"""Joints of the robot in MuJoCo."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from handcart.backends.physics.body.joint_group import JointGroup, Vector

from .mujoco_engine import MujocoEngine


class MujocoJoints(JointGroup):
    """See `JointGroup`. A drive is a servo of its speed, in each step of the solver.

    As stiff as it can be: alone, it is at the speed that it is told after a step.
    """

    def __init__(self, engine: MujocoEngine, names: Sequence[str]) -> None:
        """Those of the model by their names."""
        self._engine, model = engine, engine.model
        joints = [model.joint(name) for name in names]
        self._at = np.array([int(joint.qposadr[0]) for joint in joints])
        self._speed = np.array([int(joint.dofadr[0]) for joint in joints])
        self._drives = np.array([int(model.actuator(name).id) for name in names])
        self._step = float(model.opt.timestep)
        self._gain = model.dof_M0[self._speed] / self._step

    def states(self) -> tuple[Vector, Vector]:
        """See `JointGroup`."""
        data = self._engine.data
        return data.qpos[self._at], data.qvel[self._speed]

    def turn(self, speeds: Vector, most: Vector) -> None:
        """See `JointGroup`."""
        self._serve(speeds, self._gain, np.zeros(len(self._drives)), most)

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

    def push(self, torques: Vector) -> None:
        """See `JointGroup`."""
        self._engine.data.qfrc_applied[self._speed] = torques
