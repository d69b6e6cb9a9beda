"""Surveys of outside packages: their messages count, their exceptions are reported, their notes are
type-checked.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import orjson
import pytest

from handcart.backends.saved_state import NotAState
from handcart.evaluation.judging import surveys
from handcart.evaluation.judging.judge import NOTES_FILE, Judge
from handcart.evaluation.judging.survey import Claim, Survey
from handcart.networks.events.events import Ended, Started
from handcart.networks.events.run_end import RunEnd
from handcart.networks.task.preparing import Prepared, prepare
from handcart.primitives.driving.move_to import MoveTo
from handcart.primitives.outcomes.outcome import Success
from handcart.tasks.domain import Domain

DRIVE_MAP = Path(__file__).resolve().parents[3] / "tasks" / "drive_map" / "task.yaml"


class Puddles(Survey):
    """Survey of an outside package that contradicts every MOVE_TO with the number of periods it saw."""

    name = "puddles"
    effects = {"MOVE_TO": lambda survey, claim: [f"{survey.seen} puddles were gone through"]}  # noqa: RUF012
    noted = int
    seen = 0

    def look(self, robot: object) -> None:
        self.seen += 1

    def notes(self) -> int:
        return self.seen

    def go_on(self, noted: int) -> None:
        self.seen = noted

    def figures(self) -> dict[str, Any]:
        return {"puddles": self.seen}

    def faults(self) -> list[str]:
        return ["the floor is wet"]


class Broken(Puddles):
    """Raises in one of its methods."""

    name = "broken"
    effects = {"MOVE_TO": lambda survey, claim: survey.breaks("effect")}  # noqa: RUF012
    at = ""

    def breaks(self, where: str) -> list[str]:
        if self.at == where:
            raise KeyError("pond")
        return []

    def look(self, robot: object) -> None:
        self.breaks("look")

    def ended(self, *_: object) -> list[str]:
        return self.breaks("ended")

    def figures(self) -> dict[str, Any]:
        self.breaks("figures")
        return {"ponds": 1}

    def faults(self) -> list[str]:
        return self.breaks("faults")


@pytest.fixture
def prepared() -> Iterator[Prepared]:
    with prepare(DRIVE_MAP) as made:
        yield made


@pytest.fixture
def also(monkeypatch: pytest.MonkeyPatch) -> Callable[[type[Survey]], None]:
    """Makes a survey one of those that are asked."""

    def add(kind: type[Survey]) -> None:
        monkeypatch.setattr(surveys, "survey_kinds", lambda run: (*surveys.GENERAL_SURVEYS, kind))

    return add


def drive(prepared: Prepared, folder: Path | None = None) -> Judge:
    """A judge that saw a MOVE_TO of three periods."""
    judge = Judge(prepared, folder)
    action = next(item for item in prepared.task.network.actions if item.do == "MOVE_TO")
    primitive = MoveTo(place=next(iter(prepared.model.places)))
    judge.event(Started(prepared.robot.time, 1, action, primitive, 0))
    for _ in range(3):
        prepared.robot.step()
        judge.period(prepared.robot)
    judge.event(Ended(prepared.robot.time, 1, action, primitive, Success(), {}))
    return judge


def metrics(prepared: Prepared, judge: Judge) -> dict[str, Any]:
    return judge.figures(RunEnd("Success", "", "", 1, 0, 0, ()))


def test_what_a_survey_from_outside_says_counts(
    prepared: Prepared, also: Callable[[type[Survey]], None]
) -> None:
    also(Puddles)
    figures = metrics(prepared, drive(prepared))
    assert figures["puddles"] == 3
    assert "1. MOVE_TO Success: 3 puddles were gone through" in figures["untrue"]
    assert "Success: the floor is wet" in figures["untrue"]


@pytest.mark.parametrize("at", ["look", "effect", "ended", "figures", "faults"])
def test_one_that_breaks_is_named_and_the_run_goes_on(
    prepared: Prepared, also: Callable[[type[Survey]], None], at: str
) -> None:
    also(type("Muddy", (Broken,), {"at": at}))
    figures = metrics(prepared, drive(prepared))
    (words,) = [item for item in figures["untrue"] if "broke" in item]
    assert re.search(r":Muddy broke and says no more: KeyError: 'pond' \(test_surveys.py, line \d+\)", words)
    assert "path_length_m" in figures


def test_a_survey_that_is_none_is_named_before_anything_moves(monkeypatch: pytest.MonkeyPatch) -> None:
    for path, words in (
        ("gone:Gone", "the survey gone:Gone of the domain pond can't be imported: ModuleNotFoundError"),
        ("pathlib:Path", "the survey pathlib:Path of the domain pond is not a survey"),
    ):
        monkeypatch.setattr(surveys, "domains", lambda path=path: (Domain("pond", survey=path),))
        with pytest.raises(surveys.NoSurvey, match=words):
            surveys.survey_kinds()


def test_a_run_that_goes_on_takes_up_what_was_noted(
    prepared: Prepared, also: Callable[[type[Survey]], None], tmp_path: Path
) -> None:
    also(Puddles)
    drive(prepared, tmp_path)
    again = Judge(prepared, tmp_path)
    again.go_on()
    assert "1. MOVE_TO Success: 3 puddles were gone through" in again.untrue
    assert again.surveys.figures()["puddles"] == 3


def wrong_notes() -> list[tuple[Callable[[dict[str, Any]], object], str]]:
    """Return functions that damage a note, each with the expected message."""
    return [
        (lambda note: note.pop("surveys"), "no such notes: Input should be an object"),
        (lambda note: note.update(surveys=[]), "no such notes: Input should be an object"),
        (lambda note: note.update(untrue=[1]), "no such notes: 0: Input should be a valid string"),
        (lambda note: note["surveys"].pop("puddles"), "nothing was noted of puddles"),
        (lambda note: note["surveys"].update(puddles="3"), "of puddles: no such notes"),
        (lambda note: note["surveys"].update(localisation=[1, 2.0]), "of localisation: no such notes"),
        (lambda note: note["surveys"].update(path={}), "of path: no such notes"),
        (lambda note: note["surveys"]["contacts"].append({"part": "base"}), "of contacts: no such notes"),
        (lambda note: note["surveys"].update(arrival={"a": None}), "of arrival: no such notes: a: "),
    ]


@pytest.mark.parametrize("number", range(len(wrong_notes())))
def test_notes_of_another_shape_are_refused_in_a_sentence(
    prepared: Prepared, also: Callable[[type[Survey]], None], tmp_path: Path, number: int
) -> None:
    """D6: damaged notes raise NotAState, never a KeyError, and never yield metrics."""
    also(Puddles)
    drive(prepared, tmp_path)
    note = orjson.loads((tmp_path / NOTES_FILE).read_bytes())
    spoil, words = wrong_notes()[number]
    spoil(note)
    (tmp_path / NOTES_FILE).write_bytes(orjson.dumps(note) + b"\n")
    again = Judge(prepared, tmp_path)
    with pytest.raises(NotAState) as refused:
        again.go_on()
    assert str(refused.value).startswith(f"{tmp_path / NOTES_FILE}: {words}")


def test_a_claim_knows_how_all_was_before(prepared: Prepared, also: Callable[[type[Survey]], None]) -> None:
    seen: list[Claim] = []

    def sees(survey: Survey, claim: Claim) -> list[str]:
        seen.append(claim)
        return []

    also(type("Sees", (Puddles,), {"effects": {"MOVE_TO": sees}}))
    drive(prepared)
    assert seen[0].before.base == seen[0].after.base
    assert seen[0].primitive.label() == "MOVE_TO"
