"""The arm, by CAN."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from typing_extensions import override

from handcart.backends.can.drives.axis import Axis
from handcart.backends.capabilities.arm import ForceArm
from handcart.backends.commanded_parts import CommandedArm
from handcart.backends.description.can_spec import AxisSpec
from handcart.backends.hand_force import force_by_efforts
from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.numerics.arrays import FloatArray

MIN_REPORTING_JOINTS = 3  # whose torques are known, so that all directions of a force may show


class CanArm(CommandedArm):
    """Arm with a CiA 402 drive for each joint.

    In a profile mode a drive plans a ramp to its set-point; in a cyclic mode it gets a new set-point with
    each SYNC. The force on the hand is computed from the joints' torques (6077h), minus the torques that the
    arm's own weight causes by the URDF. This force includes the weight of a held object. Joints whose drives
    report no torque are excluded; if no drive reports torque, the force is zero.
    """

    def __init__(self, model: ArmModel, joints: Sequence[Axis], rated: FloatArray, period: float) -> None:
        """Take over the joints' drives.

        Args:
            model: model of the arm.
            joints: drives of the n joints, in the order of the arm.
            rated: (n,) rated efforts of the drives, in [Nm], or [N] for sliding joints.
            period: control period, in [s].
        """
        self._model, self._joints, self._rated = model, joints, rated
        self._most = np.array([joint.limits.speed for joint in joints]) * period
        self._command = self._sent = np.zeros(len(joints))

    def begin(self) -> None:
        """Set the measured positions as set-points, before the drives are enabled.

        A joint that rests at its limit is often read slightly beyond it. Its set-point is then the limit, if
        the joint can reach the limit in one control period.
        """
        measured = self.joints()
        within = self._model.clipped(measured)
        self.holds(np.where(np.abs(within - measured) <= self._most, within, measured))

    def holds(self, joints: FloatArray) -> None:
        """Take joint positions (n,) as the last commanded ones, in [rad], or [m] for sliding joints, without
        sending them.
        """
        self._command = self._sent = joints.copy()

    @override
    def joints(self) -> FloatArray:
        return np.array([joint.position for joint in self._joints])

    @override
    def hand_force(self) -> FloatArray:
        known = np.array([joint.tells_torque for joint in self._joints], dtype=np.bool_)
        measured = np.array([joint.torque for joint in self._joints]) * self._rated
        return force_by_efforts(self._model, self.joints(), measured, known)

    def pass_on(self) -> None:
        """Set the commanded joint positions as the next set-points of the joints' drives."""
        self._sent = self._command.copy()
        for joint, angle in zip(self._joints, self._sent, strict=True):
            joint.command(float(angle))


class CanForceArm(CanArm, ForceArm):
    """Arm that measures the force on the hand, because three or more of its drives report joint torques."""


def kind_of_arm(joints: Sequence[AxisSpec]) -> type[CanArm]:
    """Return the class of an arm: `CanForceArm` if three joints or more report torque, otherwise `CanArm`."""
    reporting = sum("torque" not in joint.without for joint in joints)
    return CanForceArm if reporting >= MIN_REPORTING_JOINTS else CanArm
