"""Judge of a run's outcomes, by the ground truth of a simulated world."""

from __future__ import annotations

from functools import cached_property
from pathlib import Path
from typing import Any

from typing_extensions import override

from handcart.backends.robot.robot import Robot
from handcart.backends.saved_state import NotAState
from handcart.networks.events.events import Ended, Event, Started
from handcart.networks.events.run_end import RunEnd
from handcart.networks.events.run_observer import RunObserver
from handcart.networks.task.preparing import Prepared

from .survey import SurveyedRun
from .survey_notes import SurveyNotes, as_noted
from .surveys import Surveys

NOTES_FILE = "judged.jsonl"


class Judge(RunObserver):
    """Observer that compares the outcomes of a run with the ground truth, by all surveys (evaluations) that
    fit it.
    """

    def __init__(self, prepared: Prepared, folder: Path | None = None) -> None:
        """Prepare to judge a run that is about to start or continue.

        Without a simulated world nothing is judged by ground truth. The run's `folder` receives the notes
        that a continued run needs and that cannot be computed again.

        Raises:
            NoSurvey: a domain names a class that is not a survey.
        """
        run = SurveyedRun.of(prepared, folder)
        self.surveys = Surveys(run)
        self.untrue: list[str] = []
        """Messages about the outcomes that the ground truth contradicts."""
        self._run = run
        self._path = None if folder is None or run.scene is None else folder / NOTES_FILE

    @cached_property
    def _notes(self) -> SurveyNotes | None:
        return None if self._path is None else SurveyNotes(self._path.parent, NOTES_FILE)

    @override
    def period(self, robot: Robot) -> None:
        self.surveys.look(robot)

    def event(self, event: Event) -> None:
        """Record the ground truth if the event is an action's start, and check the action's outcome against
        it if the event is the action's end.
        """
        if isinstance(event, Started):
            self.surveys.started(event.number, event.primitive)
        elif isinstance(event, Ended):
            wrong = self.surveys.ended(event.number, event.primitive, event.outcome)
            word = type(event.outcome).__name__
            self.untrue += [f"{event.number}. {event.action.do} {word}: {item}" for item in wrong]
            if self._notes is not None:
                note = {"untrue": self.untrue, "surveys": self.surveys.notes()}
                self._notes.add(self._run.world.time, note)

    def go_on(self) -> None:
        """Load the false outcomes and observations that the surveys (observers that evaluate a run) noted
        before the run was interrupted.

        Raises:
            NotAState: the notes are damaged or have another format.
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
            self.untrue += [f"Success: {fault}" for fault in self.surveys.faults()]
        return {**figures, "untrue": self.untrue + self.surveys.broken}
