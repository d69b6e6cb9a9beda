"""Figures of opening and closing doors, by the ground truth."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from typing_extensions import override

from handcart.backends.robot.robot import Robot
from handcart.evaluation.judging.survey import FiguresSurvey, SurveyedRun
from handcart.primitives.contract.action_primitive import ActionPrimitive
from handcart.primitives.doors.move_door import MoveDoor
from handcart.primitives.outcomes.outcome import Outcome, Success

from .door_effects import DOOR_EFFECTS
from .door_truth import door_of, hinge_errors


class DoorSurvey(FiguresSurvey):
    """Evaluation of door tasks by the errors of found hinges and the largest true force on the hand."""

    name = "doors"
    effects = DOOR_EFFECTS
    shown: ClassVar = frozenset({"OPEN", "CLOSE"})

    @override
    def __init__(self, run: SurveyedRun) -> None:
        super().__init__(run)
        self._moves = False

    @override
    def started(self, number: int, primitive: ActionPrimitive) -> None:
        self._moves = isinstance(primitive, MoveDoor)

    @override
    def look(self, robot: Robot) -> None:
        if self._moves:
            force = float(np.linalg.norm(self.run.world.hand_force))
            self._figures["door_force_n"] = max(self._figures.get("door_force_n", 0.0), round(force, 2))

    @override
    def ended(self, number: int, primitive: ActionPrimitive, outcome: Outcome) -> list[str]:
        self._moves = False
        if isinstance(primitive, MoveDoor) and isinstance(outcome, Success):
            part = door_of(self, primitive.door)
            found = None if part is None else hinge_errors(self, primitive, part.spec.true_joint())
            if found is not None and primitive.label() == "OPEN":
                self._figures["hinge_off_mm"] = round(found.place_mm, 2)
                self._figures["axis_off_deg"] = round(found.axis_deg, 3)
                self._figures["radius_off_mm"] = round(found.radius_mm, 2)
                self._figures["hinge_sigma_mm"] = float(primitive.facts["hinge_sigma_mm"])
        return []
