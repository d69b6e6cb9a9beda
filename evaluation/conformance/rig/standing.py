"""Check that a robot is at rest, by its own readings and by the ground truth."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from handcart.backends.backend import Backend
from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.base import Base
from handcart.backends.capabilities.gripper import Gripper
from handcart.backends.ground_truth import GroundTruth
from handcart.evaluation.judging.true_changes import not_still
from handcart.robotics.numerics.arrays import FloatArray

from .parts import part_of

MAX_REST_MOTION = {"wheels": 2e-3, "joints": 2e-3, "width": 5e-4}
"""Allowed apparent motion at rest, of wheels in [m], joints in [rad] and the gripper's width in [m]."""


@dataclass(frozen=True)
class TrueState:
    """State of wheels, joints and fingers at one instant and, if simulated, the ground truth."""

    readings: dict[str, FloatArray]
    truth: GroundTruth | None

    @classmethod
    def of(cls, backend: Backend) -> TrueState:
        """Return the current readings of wheels, joints and fingers of a backend, with its ground truth if
        known.
        """
        base, arm, gripper = part_of(backend, Base), part_of(backend, Arm), part_of(backend, Gripper)
        readings: dict[str, FloatArray] = {}
        if base is not None:
            readings["wheels"] = np.array(list(base.wheel_travel()))
        if arm is not None:
            readings["joints"] = arm.joints().copy()
        if gripper is not None:
            readings["width"] = np.array([gripper.width()])
        return cls(readings, backend.ground_truth())

    def moved(self, after: TrueState) -> list[str]:
        """Describe the parts that moved from this state to the later state `after`; empty if all rested."""
        wrong = []
        for name, room in MAX_REST_MOTION.items():
            if name in self.readings:
                far = float(np.abs(after.readings[name] - self.readings[name]).max(initial=0.0))
                if not far <= room:
                    wrong.append(f"{name} move by {far:.3g}")
        return wrong + self.truly_moved(after)

    def truly_moved(self, after: TrueState) -> list[str]:
        """Describe what moved by the ground truth from this state to `after`; empty without a simulation."""
        if self.truth is None or after.truth is None:
            return []
        return [f"truly moves: {text}" for text in not_still(self.truth, after.truth)]
