"""What the grippers of all simulated backends share."""

from __future__ import annotations

from abc import abstractmethod
from typing import ClassVar

from handcart.backends.capabilities.gripper import Gripper
from handcart.backends.description.robot_file import GripperSpec
from handcart.backends.description.simulated_errors import Errors
from handcart.backends.limits import checked_width
from handcart.backends.plain_values import Kinds
from handcart.backends.simulation.keyed_noise import keyed


class SimulatedGripper(Gripper):
    """Takes commands, and reads the opening with noise."""

    STATE: ClassVar[Kinds] = {"_command": float, "_now": int, "_pressing": bool}
    """Attributes that a checkpoint keeps, with their types."""

    def __init__(self, spec: GripperSpec, errors: Errors, width: float, seed: int) -> None:
        """`width` is the opening at first, in [m]."""
        self._spec, self._seed = spec, seed
        self._sigma = errors.opening_mm / 1e3
        self._command = width
        self._now, self._pressing = 0, False

    @abstractmethod
    def true_width(self) -> float:
        """The opening, in [m]."""

    def command(self) -> float:
        """See `Gripper`."""
        return self._command

    def move(self, width: float) -> None:
        """See `Gripper`."""
        self._command = checked_width(self._spec, width)

    def width(self) -> float:
        """See `Gripper`."""
        noise = self._sigma * keyed(self._seed, "width", self._now).standard_normal()
        return float(max(0.0, self.true_width() + noise))

    def closed_on_something(self) -> bool:
        """See `Gripper`."""
        return self._pressing

    def halt(self) -> None:
        """Hold: fingers that press go on pressing, those that move stop."""
        if not self._pressing:
            self._command = min(max(0.0, self.true_width()), self._spec.opening_mm / 1e3)
