"""All surveys of a run, called in turn."""

from __future__ import annotations

import traceback
from collections.abc import Callable, Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

from handcart.backends.ground_truth import GroundTruth
from handcart.backends.robot.robot import Robot
from handcart.backends.saved_state import NotAState
from handcart.files.errors import InputError
from handcart.networks.task.preparing import Prepared
from handcart.primitives.contract.action_primitive import ActionPrimitive
from handcart.primitives.outcomes.outcome import Fail, Outcome, Success
from handcart.primitives.outcomes.residual import ResidualKind
from handcart.primitives.preconditions.hand_use import Hand
from handcart.primitives.restoring.snapshot import RESIDUAL_SIGMAS
from handcart.tasks.domain import domains, imported

from .arrival_survey import ArrivalSurvey
from .base_surveys import LocalisationSurvey, PathSurvey
from .contact_survey import ContactSurvey
from .hand_claims import HAND_NAME, false_hold, things_held
from .map_survey import MapSurvey
from .sensor_sigmas import BASE_SIGMA_DEG, BASE_SIGMA_MM
from .survey import Claim, Survey, SurveyedRun
from .survey_notes import as_noted
from .true_changes import MOST_TURNED_DEG, disturbed, not_restored, turned

GENERAL_SURVEYS = (PathSurvey, ContactSurvey, LocalisationSurvey, ArrivalSurvey, MapSurvey)
MOST_DISTURBED_MM = 10.0  # largest allowed motion of a body that a primitive does not move
SurveyT = TypeVar("SurveyT", bound=Survey)
T = TypeVar("T")


class NoSurvey(InputError):
    """Error for an application domain whose class for checking runs is not a `Survey`; raised
    before a run.
    """


def survey_kinds(run: SurveyedRun | None = None) -> tuple[type[Survey], ...]:
    """Return the general classes of surveys (evaluations of a run) and those of the application domains.

    Args:
        run: run that the surveys are for; surveys of domains that it does not use are omitted. None: all.

    Raises:
        NoSurvey: a class cannot be imported, or is not a survey.
    """
    named = [
        (domain.name, domain.survey)
        for domain in domains()
        if domain.survey is not None and (run is None or run.concerns(domain))
    ]
    return (*GENERAL_SURVEYS, *(_kind(name, path) for name, path in named))


@cache
def _kind(domain: str, path: str) -> type[Survey]:
    try:
        kind = imported(path)
    except Exception as error:  # a foreign module may raise anything
        reason = f"{type(error).__name__}: {error}"
        raise NoSurvey(f"the survey {path} of the domain {domain} can't be imported: {reason}") from error
    if not (isinstance(kind, type) and issubclass(kind, Survey)):
        raise NoSurvey(
            f"the survey {path} of the domain {domain} is not a survey; allowed: a subclass of Survey"
        )
    return kind


class Surveys:
    """Surveys (observers) that evaluate one run by ground truth; one that raises an exception is removed."""

    def __init__(self, run: SurveyedRun) -> None:
        """Create the surveys for a run that is about to start or continue."""
        self.run = run
        self.broken: list[str] = []
        """Messages about the surveys that raised an exception."""
        self._every: list[Survey] = []
        self._before: GroundTruth | None = None
        for kind in survey_kinds(run):
            self._add(kind)

    def _add(self, kind: type[Survey]) -> None:
        try:
            if kind.applies(self.run):
                self._every.append(kind(self.run))
        except InputError:  # its notes in the run's folder are damaged
            raise
        except Exception as error:
            self.broken.append(_broke(kind, error))

    def of(self, kind: type[SurveyT]) -> SurveyT | None:
        """Return the run's survey (observer that evaluates the run) of a class; None if it has none."""
        return next((survey for survey in self._every if isinstance(survey, kind)), None)

    @property
    def shown(self) -> frozenset[str]:
        """Names of the primitives whose camera pictures a run's overview shows before those of others."""
        return frozenset().union(*(survey.shown for survey in self._every))

    def look(self, robot: Robot) -> None:
        """Let every survey observe the robot after a period."""
        for survey in self._every:
            try:
                survey.look(robot)
            except Exception as error:
                self._leave_out(survey, error)

    def started(self, number: int, primitive: ActionPrimitive) -> None:
        """Record the ground truth at the start of an action, and notify every survey (observer that evaluates
        the run).
        """
        self._before = self.run.robot.backend.ground_truth()
        for _ in self._asked(lambda survey: survey.started(number, primitive)):
            pass

    def ended(self, number: int, primitive: ActionPrimitive, outcome: Outcome) -> list[str]:
        """Return a message for each claim of an ended action's outcome that contradicts the ground truth."""
        after = self.run.robot.backend.ground_truth()
        wrong: list[str] = []
        if self._before is not None and after is not None:
            if isinstance(outcome, Fail):
                wrong = not_restored(self._before, after, self.run.spec, self._base_sigma(outcome))
            elif isinstance(outcome, Success):
                wrong = self._false_effect(Claim(primitive, self._before, after))
        more = [untrue for _, untrue in self._asked(lambda survey: survey.ended(number, primitive, outcome))]
        return wrong + [item for untrue in more for item in untrue]

    def _base_sigma(self, fail: Fail) -> tuple[float, float]:
        """Return the standard deviation of the measured base motion, in [mm] and [deg]; with a GNSS as
        claimed.
        """
        position = fail.residuals.of(ResidualKind.BASE_POSITION_UNCERTAINTY)
        heading = fail.residuals.of(ResidualKind.BASE_HEADING_UNCERTAINTY)
        if not self.run.robot.localization.POSE_JUMPS or position is None or heading is None:
            return BASE_SIGMA_MM, BASE_SIGMA_DEG
        claimed = position.value / RESIDUAL_SIGMAS, heading.value / RESIDUAL_SIGMAS
        return max(BASE_SIGMA_MM, claimed[0]), max(BASE_SIGMA_DEG, claimed[1])

    def _false_effect(self, claim: Claim) -> list[str]:
        """Return a message for each false claim of a Success; without a survey of the primitive, its
        disturbances only.
        """
        own = _own(claim, self.run)
        wrong = [
            f"it moved {text} mm (at most {MOST_DISTURBED_MM:.0f})"
            for text in disturbed(claim.before, claim.after, MOST_DISTURBED_MM, own)
        ]
        wrong += [f"it turned {text}" for text in turned(claim.before, claim.after, MOST_TURNED_DEG, own)]
        wrong += false_hold(claim, self.run.model)
        own_word = getattr(claim.primitive, "false_effect", None)
        if own_word is not None:
            return wrong + list(own_word(self.run.world, claim.before))
        label = claim.primitive.label()
        checks = self._asked(lambda survey: survey.effects[label](survey, claim), label)
        return wrong + [item for _, untrue in checks for item in untrue]

    def notes(self) -> dict[str, Any]:
        """Return the observations of each survey (observer that evaluates the run), by the survey's name.

        An interrupted run can be continued with them.
        """
        noting = [survey_ for survey_ in self._every if survey_.noted is not None]
        return {survey.name: notes for survey, notes in self._asked(lambda item: item.notes(), among=noting)}

    def go_on(self, notes: Mapping[str, Any], path: Path) -> None:
        """Hand each survey (observer of a run) its observations from the interrupted run that this run
        continues.

        Args:
            notes: observations by name of the survey, as read from a file.
            path: path of this file, used in messages.

        Raises:
            NotAState: the notes are damaged or have another format.
        """
        for survey in [survey_ for survey_ in self._every if survey_.noted is not None]:
            try:
                survey.go_on(as_noted(notes[survey.name], survey.noted))
            except KeyError:
                raise NotAState(f"{path}: nothing was noted of {survey.name}") from None
            except ValueError as error:
                raise NotAState(f"{path}: of {survey.name}: {error}") from None

    def figures(self) -> dict[str, Any]:
        """Return the metrics that all surveys (observers) computed for a run that has ended, by name."""
        by_survey = [figures for _, figures in self._asked(lambda survey: survey.figures())]
        return {name: value for item in by_survey for name, value in item.items()}

    def faults(self) -> list[str]:
        """Return a line for each survey (observer) that found the world other than a Success of the run
        claims.

        The line holds the reasons that the survey gives.
        """
        by_survey = [faults for _, faults in self._asked(lambda survey: survey.faults())]
        return ["; ".join(faults) for faults in by_survey if faults]

    def report(self, prepared: Prepared, folder: Path) -> None:
        """Write the reports of all surveys (observers that evaluated a run) into the folder of the run, after
        its end.

        Raises:
            OSError: writing failed, for example because the disk is full.
        """
        self._write(lambda survey: survey.report(prepared, folder))

    def draw(self, folder: Path) -> None:
        """Draw the pictures of all surveys (observers that evaluate a run) into the folder of a run that has
        ended.

        Raises:
            OSError: writing failed, for example because the disk is full.
        """
        self._write(lambda survey: survey.draw(folder))

    def _write(self, write: Callable[[Survey], None]) -> None:
        for survey in self._every:
            try:
                write(survey)
            except OSError:
                raise
            except Exception as error:
                self._leave_out(survey, error)

    def _asked(
        self, ask: Callable[[Survey], T], label: str | None = None, among: list[Survey] | None = None
    ) -> Iterator[tuple[Survey, T]]:
        """Yield each survey with its answer, only of those that check the primitive `label` if it is
        given.
        """
        for survey in list(self._every if among is None else among):
            if label is not None and label not in survey.effects:
                continue
            try:
                answer = ask(survey)
            except Exception as error:
                self._leave_out(survey, error)
            else:
                yield survey, answer

    def _leave_out(self, survey: Survey, error: Exception) -> None:
        self._every = [survey_ for survey_ in self._every if survey_ is not survey]
        self.broken.append(_broke(type(survey), error))


def _own(claim: Claim, run: SurveyedRun) -> set[str]:
    """Return the names of the bodies that a primitive may move: held before or after, or meant to be touched.

    A body held before the start of a primitive that requires an empty hand is not included: it would be
    dropped.
    """
    held = things_held(claim.after)
    if claim.primitive.hand_use().before is not Hand.EMPTY:
        held |= things_held(claim.before)
    meant = [contact for contact in claim.primitive.meant_contacts(run.model) if contact.part == HAND_NAME]
    return held | {
        name for name in claim.before.bodies if any(item.covers(HAND_NAME, name) for item in meant)
    }


def _broke(kind: type[Survey], error: Exception) -> str:
    """Return a message with the survey, the exception and its source line."""
    at = traceback.extract_tb(error.__traceback__)[-1]
    where = f"{Path(at.filename).name}, line {at.lineno}"
    which = f"{kind.__module__}:{kind.__name__}"
    return f"the survey {which} broke and says no more: {type(error).__name__}: {error} ({where})"
