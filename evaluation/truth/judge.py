"""Whether outcomes tell the truth, by the ground truth of a simulated world."""

from __future__ import annotations

from functools import cached_property
from pathlib import Path
from typing import Any

from typing_extensions import override

from handcart.backends.robot.robot import Robot
from handcart.backends.saved_state import NotAState
from handcart.networks.coordination.events import Ended, Event, Started
from handcart.networks.coordination.run_end import RunEnd
from handcart.networks.run_observer import RunObserver
from handcart.networks.task.preparing import Prepared

from .survey import SurveyedRun
from .survey_notes import SurveyNotes, as_noted
from .surveys import Surveys

NOTES = "judged.jsonl"


class Judge(RunObserver):
    """Holds the outcomes of a run against the ground truth, by all surveys that apply."""

    def __init__(self, prepared: Prepared, folder: Path | None = None) -> None:
        """Judge a run that hasn't started, or goes on; where the backend isn't simulated, nothing is claimed.

        In the run's `folder` is noted what a run that breaks off couldn't tell again.

        Raises:
            NoSurvey: a domain names a survey that is none.
        """
        run = SurveyedRun.of(prepared, folder)
        self.surveys = Surveys(run)
        self.untrue: list[str] = []
        """Outcomes that the ground truth contradicts, in words."""
        self._run = run
        self._path = None if folder is None or run.scene is None else folder / NOTES

    @cached_property
    def _notes(self) -> SurveyNotes | None:
        return None if self._path is None else SurveyNotes(self._path.parent, NOTES)

    @override
    def period(self, robot: Robot) -> None:
        self.surveys.look(robot)

    def event(self, event: Event) -> None:
        """Take the truth down when an action starts, compare when it has ended."""
        if isinstance(event, Started):
            self.surveys.started(event.number, event.primitive)
        elif isinstance(event, Ended):
            wrong = self.surveys.ended(event.number, event.primitive, event.outcome)
            word = type(event.outcome).__name__
            self.untrue += [f"{event.number}. {event.action.do} {word}: {each}" for each in wrong]
            if self._notes is not None:
                note = {"untrue": self.untrue, "surveys": self.surveys.notes()}
                self._notes.add(self._run.world.time, note)

    def go_on(self) -> None:
        """Take up what was noted of the run that this one goes on with.

        Raises:
            NotAState: what was noted there makes no sense.
        """
        if self._notes is None or self._path is None:
            return
        if not (noted := self._notes.until(self._run.world.time)):
            return
        try:
            self.untrue = as_noted(noted[-1].get("untrue"), list[str])
            notes = as_noted(noted[-1].get("surveys"), dict[str, Any])
        except ValueError as error:
            raise NotAState(f"{self._path}: {error}") from None
        self.surveys.go_on(notes, self._path)

    @override
    def figures(self, end: RunEnd) -> dict[str, Any]:
        figures = self.surveys.figures()
        if end.outcome == "Success":
            self.untrue += [f"Success: {each}" for each in self.surveys.faults()]
        return {**figures, "untrue": self.untrue + self.surveys.broken}
