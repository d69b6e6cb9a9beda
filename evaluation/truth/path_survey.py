"""How far the base drove, by its odometry."""

from __future__ import annotations

from typing import Any

from handcart.backends.robot.robot import Robot

from .survey import Survey
from .surveyed_run import SurveyedRun


class PathSurvey(Survey):
    """Adds up the way; needs no ground truth."""

    name = "path"
    noted = float

    def __init__(self, run: SurveyedRun) -> None:
        """See `Survey`."""
        super().__init__(run)
        self._at, self._driven = run.robot.localization.odometry_pose, 0.0

    @classmethod
    def applies(cls, run: SurveyedRun) -> bool:
        """See `Survey`."""
        return True

    def look(self, robot: Robot) -> None:
        """See `Survey`."""
        self._driven += robot.localization.odometry_pose.distance(self._at)
        self._at = robot.localization.odometry_pose

    def notes(self) -> float:
        """See `Survey`."""
        return self._driven

    def go_on(self, noted: float) -> None:
        """See `Survey`."""
        self._driven = noted

    def figures(self) -> dict[str, Any]:
        """See `Survey`."""
        return {"path_length_m": round(self._driven, 3)}
