"""Arms and grippers that keep a command until the backend hands it on."""

from __future__ import annotations

from typing_extensions import override

from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.gripper import Gripper
from handcart.backends.description.robot_file import GripperSpec
from handcart.backends.limits import checked_joints, checked_width
from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.numerics.arrays import FloatArray


class CommandedArm(Arm):
    """Base class of arms that store the commanded joint positions until the next step, after a check against
    the limits.
    """

    _model: ArmModel
    _most: FloatArray
    """Largest step (n,) of each joint in a period, in [rad] or [m]."""
    _command: FloatArray
    """Joints (n,) commanded for the end of the next period, in [rad] or [m]."""
    _sent: FloatArray
    """Joints (n,) that were sent last, in [rad] or [m]."""

    @override
    def move(self, joints: FloatArray) -> None:
        self._command = checked_joints(self._model, joints, self._sent, self._most)

    @override
    def command(self) -> FloatArray:
        return self._command.copy()

    def halt(self) -> None:
        """Discard a command that has not been sent, so that the arm holds the joint positions that were sent
        last.
        """
        self._command = self._sent.copy()


class CommandedGripper(Gripper):
    """Base class of grippers that store the commanded width after a check against the largest opening."""

    _spec: GripperSpec
    _command: float
    """Commanded width, in [m]."""

    @override
    def command(self) -> float:
        return self._command

    @override
    def move(self, width: float) -> None:
        self._command = checked_width(self._spec, width)
