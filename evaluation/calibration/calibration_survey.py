"""Compare calibrations with the truth or with another measurement."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from typing_extensions import override

from handcart.backends.robot.robot import Robot
from handcart.evaluation.judging.survey import Claim, FiguresSurvey, SurveyedRun
from handcart.primitives.contract.action_primitive import ActionPrimitive
from handcart.primitives.outcomes.calibrated import Calibrated
from handcart.primitives.outcomes.outcome import Outcome, Success

from .calibration_claims import camera_faults, suspension_faults
from .camera_survey import camera_figures
from .laser_survey import LaserSurvey

CAMERA, SUSPENSION = "CALIBRATE_CAMERA", "CALIBRATE_SUSPENSION"


def _camera(survey: CalibrationSurvey, claim: Claim) -> list[str]:
    return camera_faults(survey.run.spec, survey.run.seed, claim.primitive.evidence.calibrated)


def _suspension(survey: CalibrationSurvey, claim: Claim) -> list[str]:
    return suspension_faults(survey.spots(), claim.primitive.evidence.calibrated)


class CalibrationSurvey(FiguresSurvey):
    """Evaluation of calibrations by the ground truth.

    For the suspension, it simulates lasers on the base whose spots on walls show the base's motion, as in
    Hatano et al. (2000).
    """

    name = "calibration"
    effects: ClassVar = {CAMERA: _camera, SUSPENSION: _suspension}

    @override
    def __init__(self, run: SurveyedRun) -> None:
        super().__init__(run)
        self._lasers: LaserSurvey | None = None

    @override
    def started(self, number: int, primitive: ActionPrimitive) -> None:
        self._lasers = LaserSurvey(self.run.world) if primitive.label() == SUSPENSION else None

    @override
    def look(self, robot: Robot) -> None:
        if self._lasers is not None:
            self._lasers.look(robot)

    @override
    def ended(self, number: int, primitive: ActionPrimitive, outcome: Outcome) -> list[str]:
        if isinstance(outcome, Success):
            self._take(primitive.label(), primitive.evidence.calibrated)
        self._lasers = None
        return []

    def _take(self, do: str, found: Mapping[str, Calibrated]) -> None:
        """Record the figures of a successful calibration."""
        spec = self.run.spec
        if do == CAMERA and spec.hand_camera is not None:
            self._figures |= camera_figures(spec, spec.hand_camera, self.run.seed, found)
        elif do == SUSPENSION:
            values = {key.rpartition(".")[2]: calibrated.value for key, calibrated in found.items()}
            self._figures |= {
                key: round(value, 4) for key, value in values.items() if isinstance(value, float)
            }
            self._figures |= self.spots()

    def spots(self) -> dict[str, float]:
        """Return suspension parameters, measured by laser beams from the robot, by name with unit.

        The result is empty if no lasers are simulated.
        """
        return {} if self._lasers is None else self._lasers.figures()
