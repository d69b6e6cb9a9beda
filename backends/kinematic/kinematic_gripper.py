"""The gripper of the kinematic robot."""

from __future__ import annotations

from handcart.backends.description.robot_file import GripperSpec
from handcart.backends.simulation.body.fingers import Fingers
from handcart.backends.simulation.body.hand import Hand
from handcart.backends.simulation.body.simulated_gripper import SimulatedGripper

_PRESSES = 2e-4  # commanded this far beyond where they stand, the fingers press [m]


class KinematicGripper(SimulatedGripper):
    """Fingers that close at constant speed, and hold what is between them as if it were glued."""

    def __init__(self, spec: GripperSpec, hand: Hand, period: float, seed: int) -> None:
        super().__init__(spec, hand.scene.robot.errors, hand.scene.width, seed)
        self._step = spec.speed_mm_s / 1e3 * period
        self._scene, self._fingers = hand.scene, Fingers(hand)

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
