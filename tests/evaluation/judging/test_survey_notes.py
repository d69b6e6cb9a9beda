"""Notes of a survey can be read by a run that continues."""

import os
from pathlib import Path

import pytest

from handcart.evaluation.judging.survey_notes import SurveyNotes
from handcart.networks.run_files.run_folder import NoRun

NAME = "notes.jsonl"


def test_a_run_that_goes_on_finds_what_was_noted_before(tmp_path: Path) -> None:
    notes = SurveyNotes(tmp_path, NAME)
    assert notes.until(100.0) == []
    for second in (1.0, 2.0, 3.0):
        notes.add(second, {"laid": {}})
    with (tmp_path / NAME).open("ab") as file:
        file.write(b'{"time_s":4.0,"la')  # a crash in the middle of a line
    again = SurveyNotes(tmp_path, NAME)
    assert [note["time_s"] for note in again.until(2.0)] == [1.0, 2.0]
    again.add(2.5, {"laid": {}})
    assert [note["time_s"] for note in SurveyNotes(tmp_path, NAME).until(100.0)] == [1.0, 2.0, 2.5]


def test_a_disk_that_takes_nothing_changes_nothing(tmp_path: Path) -> None:
    notes = SurveyNotes(tmp_path / "missing", NAME)
    notes.add(1.0, {"laid": {}})
    assert notes.until(1.0) == []


def test_lines_that_are_no_notes_are_passed_over(tmp_path: Path) -> None:
    (tmp_path / NAME).write_text('[]\n7\n{"time_s": "soon"}\n{"laid": {}}\n{"time_s": 1, "laid": {}}\n')
    assert [note["time_s"] for note in SurveyNotes(tmp_path, NAME).until(2.0)] == [1]


def test_notes_larger_than_any_run_makes_them_are_refused(tmp_path: Path) -> None:
    (tmp_path / NAME).touch()
    os.truncate(tmp_path / NAME, 10**11)
    with pytest.raises(NoRun, match="more than"):
        SurveyNotes(tmp_path, NAME).until(1.0)
