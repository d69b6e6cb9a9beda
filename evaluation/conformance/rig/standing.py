"""Whether what should stand still does, by the robot's own readings and by the truth."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from handcart.backends.backend import Backend
from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.base import Base
from handcart.backends.capabilities.gripper import Gripper
from handcart.backends.ground_truth import GroundTruth
from handcart.evaluation.truth.true_changes import not_still

from .parts import part_of

HELD = {"wheels": 2e-3, "joints": 2e-3, "width": 5e-4}
"""[m], [rad], [m] by which what stands may seem to move."""


@dataclass(frozen=True)
class TrueState:
    """Where everything that can move is at one instant."""

    readings: dict[str, NDArray[np.float64]]
    truth: GroundTruth | None

    @classmethod
    def of(cls, backend: Backend) -> TrueState:
        """As the backend has it now."""
        base, arm, gripper = part_of(backend, Base), part_of(backend, Arm), part_of(backend, Gripper)
        readings: dict[str, NDArray[np.float64]] = {}
        if base is not None:
            readings["wheels"] = np.array(list(base.wheel_travel()))
        if arm is not None:
            readings["joints"] = arm.joints().copy()
        if gripper is not None:
            readings["width"] = np.array([gripper.width()])
        return cls(readings, backend.ground_truth())

    def moved(self, after: TrueState) -> list[str]:
        """What moved until `after`, in words."""
        wrong = []
        for name, room in HELD.items():
            if name in self.readings:
                far = float(np.abs(after.readings[name] - self.readings[name]).max(initial=0.0))
                if not far <= room:
                    wrong.append(f"{name} move by {far:.3g}")
        return wrong + self.truly_moved(after)

    def truly_moved(self, after: TrueState) -> list[str]:
        """What moved until `after` by the truth, in words; nothing where nothing is simulated."""
        if self.truth is None or after.truth is None:
            return []
        return [f"truly moves: {each}" for each in not_still(self.truth, after.truth)]
