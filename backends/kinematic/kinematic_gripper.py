"""The gripper of the kinematic robot."""

from __future__ import annotations

from typing import ClassVar

from handcart.backends.gripper import Gripper
from handcart.backends.limits import checked_width
from handcart.backends.robot_file import GripperSpec
from handcart.backends.scene.fingers import Fingers
from handcart.backends.scene.hand import Hand
from handcart.backends.scene.keyed_noise import keyed

_PRESSES = 2e-4  # commanded this far beyond where they stand, the fingers press [m]


class KinematicGripper(Gripper):
    """Fingers that close at constant speed, and hold what is between them as if it were glued."""

    STATE: ClassVar = {"_command": float, "_now": int, "_pressing": bool}
    """Attributes that a checkpoint keeps, with their types."""

    def __init__(self, spec: GripperSpec, hand: Hand, period: float, seed: int) -> None:
        self._sigma = hand.scene.robot.errors.opening_mm / 1e3
        self._spec, self._step = spec, spec.speed_mm_s / 1e3 * period
        self._scene, self._fingers, self._seed = hand.scene, Fingers(hand), seed
        self._command = hand.scene.width
        self._now, self._pressing = 0, False

    def command(self) -> float:
        """See `Gripper`."""
        return self._command

    def move(self, width: float) -> None:
        """See `Gripper`."""
        self._command = checked_width(self._spec, width)

    def width(self) -> float:
        """See `Gripper`."""
        noise = self._sigma * keyed(self._seed, "width", self._now).standard_normal()
        return float(max(0.0, self._scene.width + noise))

    def closed_on_something(self) -> bool:
        """See `Gripper`."""
        return self._pressing

    def halt(self) -> None:
        """Hold: fingers that press go on pressing, those that move stop."""
        if not self._pressing:
            self._command = self._scene.width

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
