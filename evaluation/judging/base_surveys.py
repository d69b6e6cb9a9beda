"""Surveys of the base: its localization error by ground truth, and the length of its path."""

from __future__ import annotations

import math
from typing import Any

from typing_extensions import override

from handcart.backends.robot.robot import Robot

from .survey import Survey, SurveyedRun


class LocalisationSurvey(Survey):
    """Evaluation of localization by RMS and maximum of the base's pose error over all periods."""

    name = "localisation"
    noted = tuple[int, float, float, float]

    @override
    def __init__(self, run: SurveyedRun) -> None:
        super().__init__(run)
        self.periods = 0
        self.squares = 0.0
        """Sum of the squared position errors, in [m²]."""
        self.farthest = 0.0
        """Largest position error, in [m]."""
        self.turned = 0.0
        """Largest heading error, in [rad]."""

    @classmethod
    @override
    def applies(cls, run: SurveyedRun) -> bool:
        return run.scene is not None

    def look(self, robot: Robot) -> None:
        """Update the statistics of localization errors with the error in this period, if the robot is located
        on the map.
        """
        if not robot.localization.is_located:
            return
        pose, truth = robot.pose, self.run.base_on_map
        off = pose.distance(truth)
        self.periods += 1
        self.squares += off * off
        self.farthest = max(self.farthest, off)
        self.turned = max(self.turned, pose.turn(truth))

    @override
    def notes(self) -> tuple[int, float, float, float]:
        return self.periods, self.squares, self.farthest, self.turned

    @override
    def go_on(self, noted: tuple[int, float, float, float]) -> None:
        self.periods, self.squares, self.farthest, self.turned = noted

    def figures(self) -> dict[str, float]:
        """Return the base's RMS and maximum pose error in [mm] and [deg]; empty before the first period."""
        if not self.periods:
            return {}
        return {
            "localisation_mm_rms": round(1e3 * math.sqrt(self.squares / self.periods), 2),
            "localisation_mm_max": round(1e3 * self.farthest, 2),
            "localisation_deg_max": round(math.degrees(self.turned), 3),
        }


class PathSurvey(Survey):
    """Observer of a run that measures the driven path length by odometry; it needs no ground truth."""

    name = "path"
    noted = float

    @override
    def __init__(self, run: SurveyedRun) -> None:
        super().__init__(run)
        self._at, self._driven = run.robot.localization.odometry_pose, 0.0

    @classmethod
    @override
    def applies(cls, run: SurveyedRun) -> bool:
        return True

    @override
    def look(self, robot: Robot) -> None:
        now = robot.localization.odometry_pose
        self._driven += now.distance(self._at)
        self._at = now

    @override
    def notes(self) -> float:
        return self._driven

    @override
    def go_on(self, noted: float) -> None:
        self._driven = noted

    @override
    def figures(self) -> dict[str, Any]:
        return {"path_length_m": round(self._driven, 3)}
