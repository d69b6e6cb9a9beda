"""Arm and gripper of the kinematic robot."""

from __future__ import annotations

from functools import cached_property
from typing import ClassVar

from handcart.backends.description.robot_file import GripperSpec, RobotFile
from handcart.backends.simulation.body.fingers import Fingers
from handcart.backends.simulation.body.hand import Hand
from handcart.backends.simulation.body.simulated_arm import SimulatedArm, SimulatedGripper, Vector

_PRESSES = 2e-4  # commanded this far beyond where they stand, the fingers press [m]


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


class KinematicGripper(SimulatedGripper):
    """Fingers that close at constant speed, and hold what is between them as if it were glued."""

    def __init__(self, spec: GripperSpec, hand: Hand, period: float, seed: int) -> None:
        super().__init__(spec, hand.scene.robot.errors, hand.scene.width, seed)
        self._step = spec.speed_mm_s / 1e3 * period
        self._scene, self._hand = hand.scene, hand

    @cached_property
    def _fingers(self) -> Fingers:
        return Fingers(self._hand)

    def true_width(self) -> float:
        """See `SimulatedGripper`."""
        return self._scene.width

    def advance(self, period: int) -> bool:
        """Move for a period; gives whether anything moved."""
        self._now = period
        before, held = self._scene.width, self._scene.held
        way = max(-self._step, min(self._step, self._command - before))
        if way != 0.0:
            self._fingers.set_width(before + way)
        after = self._scene.width
        stands = abs(after - before) < 1e-9
        self._pressing = stands and (self._command < after - _PRESSES or self._command <= 0.0)
        return not stands or held is not self._scene.held
