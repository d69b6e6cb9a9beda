"""The arm of the kinematic robot."""

from __future__ import annotations

from typing import ClassVar

from handcart.backends.description.robot_file import RobotFile
from handcart.backends.simulation.body.hand import Hand
from handcart.backends.simulation.body.simulated_arm import SimulatedArm, Vector


class KinematicArm(SimulatedArm):
    """Joints that reach their command within the period, but for a contact and for `ArmError`."""

    STATE: ClassVar = {**SimulatedArm.STATE, "_settled": bool, "_touching": frozenset[tuple[str, str]]}

    def __init__(self, robot: RobotFile, hand: Hand, seed: int) -> None:
        super().__init__(robot, hand.arm, hand.scene.joints, seed)
        self._hand, self._settled = hand, False
        hand.scene.joints = self._command + self._offset
        self._touching: frozenset[tuple[str, str]] = frozenset()

    def true_joints(self) -> Vector:
        """See `SimulatedArm`."""
        return self._hand.scene.joints

    def _true_force(self) -> Vector:
        return self._hand.scene.felt_force()

    def advance(self, period: int, disturbed: bool) -> frozenset[tuple[str, str]]:
        """Move for a period; gives what touches. `disturbed`: the fingers have moved."""
        changed = self._begin(period, loaded=self._hand.scene.held is not None)
        self._from = self._command.copy()
        if not changed and not disturbed and self._settled:
            return self._touching
        self._settled = not changed
        self._touching = self._hand.move(self._command + self._offset)
        return self._touching
