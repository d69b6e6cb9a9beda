"""A survey whose figures are all that it notes."""

from __future__ import annotations

from typing import Any

from .survey import Survey
from .surveyed_run import SurveyedRun


class FiguresSurvey(Survey):
    """Fills `_figures` in a run, by the names that they have in its metrics."""

    noted = dict[str, float]

    def __init__(self, run: SurveyedRun) -> None:
        """See `Survey`."""
        super().__init__(run)
        self._figures: dict[str, float] = {}

    def notes(self) -> dict[str, float]:
        """See `Survey`."""
        return self._figures

    def go_on(self, noted: dict[str, float]) -> None:
        """See `Survey`."""
        self._figures = noted

    def figures(self) -> dict[str, Any]:
        """See `Survey`."""
        return self._figures
