"""Joints of the robot in MuJoCo."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from typing_extensions import override

from handcart.backends.mujoco.engine.mujoco_engine import MujocoEngine
from handcart.backends.physics.body.joint_group import (
    FULL_TORQUE_ERROR_RAD,
    MIN_TORQUE_RATIO,
    SPEED_ERROR_TIME_S,
    JointGroup,
)
from handcart.robotics.numerics.arrays import FloatArray, IntArray

UNBOUND_TORQUE_NM = 1e6  # [Nm]
YIELDING_DRIVE_NAME = "{} gives"
"""Name of a joint's second drive, where it has one."""
_OFF = 1e-9  # [Nm] of a drive that does nothing: MuJoCo takes 0 for no limit


class MujocoJoints(JointGroup):
    """Joints of a simulated robot in MuJoCo that are moved by its drives (actuators).

    The drives' set-points move in each step of the solver. A drive is as stiff as possible: without load it
    reaches the commanded speed after one step. Compliant joints have two drives: a stiff drive with little
    effort, and a spring, whose effort grows with the distance from the set-point.
    """

    def __init__(self, engine: MujocoEngine, names: Sequence[str]) -> None:
        """Select joints of the model by their names."""
        self._engine, model = engine, engine.model
        joints = [model.joint(name) for name in names]
        self._at = _where([int(joint.qposadr[0]) for joint in joints])
        self._speed = _where([int(joint.dofadr[0]) for joint in joints])
        self._stiff = _Drives(engine, list(names))
        giving = [YIELDING_DRIVE_NAME.format(name) for name in names]
        there = {model.actuator(number).name for number in range(model.nu)}
        self._giving = _Drives(engine, giving) if there.issuperset(giving) else None
        self._step = float(model.opt.timestep)
        self._gain = model.dof_M0[self._speed] / self._step

    @override
    def states(self) -> tuple[FloatArray, FloatArray]:
        data = self._engine.data
        return data.qpos[self._at].copy(), data.qvel[self._speed].copy()

    @override
    def turn(self, speeds: FloatArray, most: FloatArray) -> None:
        self._alone(0.0, most, self._gain * speeds)

    @override
    def follow(self, off: FloatArray, rates: FloatArray, most: FloatArray, catches_up: float) -> None:
        self._alone(self._gain / catches_up, most)
        self._stiff.set_out(self._engine.data.qpos[self._at] + off + catches_up * rates, rates)

    def give(
        self, off: FloatArray, rates: FloatArray, effort: FloatArray, fastest: FloatArray, catches_up: float
    ) -> None:
        """Follow set-points compliantly, like springs, and limit the speed at which a deviation from them is
        reduced.

        Args:
            off: (n,) set-points minus present joints, in [rad] or [m].
            rates: (n,) rates of the set-points, in [rad/s] or [m/s].
            effort: (n,) maximum effort of the drives, in [Nm] or [N].
            fastest: (n,) maximum speeds at which a deviation is reduced, in [rad/s] or [m/s].
            catches_up: time constant with which a deviation is reduced, in [s].

        Raises:
            ValueError: these joints have no compliant drives.
        """
        if self._giving is None:
            raise ValueError("these joints have no drives that give")
        damping = np.maximum(SPEED_ERROR_TIME_S, FULL_TORQUE_ERROR_RAD / fastest)
        room = np.maximum(fastest - rates * np.sign(off), 0.0)
        most = np.minimum(FULL_TORQUE_ERROR_RAD, damping * room)
        begins = self._engine.data.qpos[self._at] + np.minimum(np.maximum(off, -most), most)
        pull = effort / FULL_TORQUE_ERROR_RAD
        self._stiff.serve(self._gain / catches_up, self._gain, MIN_TORQUE_RATIO * effort)
        self._stiff.set_out(begins + catches_up * rates, rates)
        self._giving.serve(pull, pull * damping, (1.0 - MIN_TORQUE_RATIO) * effort)
        self._giving.set_out(begins + damping * rates, rates)

    @override
    def stand(
        self, positions: FloatArray, most: FloatArray, share: float, rates: FloatArray | None = None
    ) -> None:
        self._alone(self._gain * share / self._step, most)
        if rates is None:
            self._stiff.set_out(positions, np.zeros(len(positions)))
        else:
            self._stiff.set_out(positions - self._engine.chunk * rates, rates)

    def spring(self, stiffness: float, damping: FloatArray, torques: FloatArray) -> None:
        """Apply springs, dampers and torques to the joints.

        The solver integrates them implicitly, because explicit dampers are unstable without ground contact.

        Args:
            stiffness: stiffness of the springs, in [Nm/rad] or [N/m]; their torque is zero at joint position
                0.
            damping: (n,) coefficients of the dampers, in [Nms/rad] or [Ns/m].
            torques: (n,) constant torques, in [Nm] or [N].
        """
        self._stiff.serve(stiffness, damping, np.full(len(torques), UNBOUND_TORQUE_NM), torques)
        self._stiff.set_out(np.zeros(len(torques)), np.zeros(len(torques)))

    @override
    def push(self, torques: FloatArray) -> None:
        self._engine.data.qfrc_applied[self._speed] = torques

    def _alone(self, pull: float | FloatArray, most: FloatArray, torques: float | FloatArray = 0.0) -> None:
        """Drive the joints by the stiff drives alone, and switch the yielding ones off.

        Args:
            pull: stiffness towards the set-points, in [Nm/rad] or [N/m].
            most: (n,) largest efforts, in [Nm] or [N].
            torques: (n,) constant efforts, in [Nm] or [N].
        """
        self._stiff.serve(pull, self._gain, most, torques)
        if self._giving is not None:
            self._giving.serve(0.0, 0.0, np.full(len(most), _OFF))


class _Drives:
    """MuJoCo's actuators, each with a set-point that moves evenly."""

    def __init__(self, engine: MujocoEngine, names: Sequence[str]) -> None:
        self._engine, model = engine, engine.model
        numbers = [int(model.actuator(name).id) for name in names]
        self._numbers = _where(numbers)
        self._goals = _where([int(model.actuator_actadr[number]) for number in numbers])

    def serve(
        self,
        pull: float | FloatArray,
        damping: float | FloatArray,
        most: FloatArray,
        torques: float | FloatArray = 0.0,
    ) -> None:
        """Set the effort of the drives: `torques` + `pull` (set-point - joint) - `damping` (speed), up to
        `most`.

        Args:
            pull: stiffness towards the set-points, in [Nm/rad] or [N/m].
            damping: in [Nms/rad] or [Ns/m].
            most: (n,) largest efforts, in [Nm] or [N].
            torques: (n,) constant efforts, in [Nm] or [N].
        """
        model, mine = self._engine.model, self._numbers
        model.actuator_gainprm[mine, 0] = pull
        bias = model.actuator_biasprm
        bias[mine, 0] = torques
        bias[mine, 1] = -pull
        bias[mine, 2] = -damping
        limits = model.actuator_forcerange
        limits[mine, 0] = -most
        limits[mine, 1] = most

    def set_out(self, positions: FloatArray, rates: FloatArray) -> None:
        """Start set-points at positions (n,) in [rad] or [m], to move at rates (n,) in [rad/s] or [m/s]."""
        data = self._engine.data
        data.act[self._goals] = positions
        data.ctrl[self._numbers] = rates


def _where(numbers: list[int]) -> slice | IntArray:
    """Return an index of array elements with these numbers: a slice, which is faster, if they are
    consecutive.
    """
    first = numbers[0] if numbers else 0
    run = slice(first, first + len(numbers))
    return run if numbers == list(range(run.start, run.stop)) else np.array(numbers)
