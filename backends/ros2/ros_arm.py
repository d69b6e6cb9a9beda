"""The arm, by ROS 2."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

import numpy as np
from typing_extensions import override

from handcart.backends.capabilities.arm import ForceArm
from handcart.backends.commanded_parts import CommandedArm
from handcart.backends.hand_force import force_by_efforts
from handcart.backends.plain_values import Kinds
from handcart.robotics.kinematics.arm_model import ArmModel
from handcart.robotics.numerics.arrays import FloatArray

from .joint_states import JointStates
from .wire.ros_errors import NotOnTheAir
from .wrench_topic import WrenchTopic


class RosArm(CommandedArm, ForceArm):
    """Arm whose joint controllers are commanded over ROS.

    In each period the controllers receive the commanded positions if these have changed; otherwise they hold
    the positions received last.
    """

    STATE: ClassVar[Kinds] = {"_command": FloatArray, "_sent": FloatArray}

    def __init__(
        self,
        model: ArmModel,
        names: Sequence[str],
        states: JointStates,
        wrench: WrenchTopic | None,
        period: float,
    ) -> None:
        """Take over the readings of the joints.

        Args:
            model: model of the arm.
            names: names of the arm's n joints in ROS.
            states: readings of the joints.
            wrench: force on the hand; None: by the joints' efforts.
            period: control period, in [s].
        """
        self._model, self._names, self._states, self._wrench = model, tuple(names), states, wrench
        self._most = model.velocity * period
        self._command = self._sent = np.zeros(len(names))

    def begin(self) -> None:
        """Set the commanded joints to the measured ones, before anything is sent.

        A joint that rests at its limit is often read slightly beyond it. Its command is then the limit, if
        the joint can reach the limit in one control period.

        Raises:
            NotOnTheAir: a measured joint is so far beyond a limit that one period is too short to reach the
                limit.
        """
        measured = self.joints()
        within = self._model.clipped(measured)
        beyond = np.flatnonzero(np.abs(within - measured) > self._most)
        if len(beyond):
            raise NotOnTheAir(
                [
                    f"the joint {self._names[joint]!r} is read at {measured[joint]:.3g} rad or m, beyond its"
                    f" limit {within[joint]:.3g}; is its sign (`reversed`) or its zero another one?"
                    for joint in beyond
                ]
            )
        self._command = self._sent = within

    @override
    def joints(self) -> FloatArray:
        return self._states.positions(self._names)

    @override
    def hand_force(self) -> FloatArray:
        if self._wrench is not None:
            return self._wrench.force()
        efforts = self._states.efforts(self._names)
        return force_by_efforts(self._model, self.joints(), efforts, np.isfinite(efforts))

    def taken(self) -> FloatArray | None:
        """Return the joint positions (n,) to send to the arm now, in [rad] or [m]; None if they did not
        change.
        """
        if np.array_equal(self._command, self._sent):
            return None
        self._sent = self._command.copy()
        return self._sent
