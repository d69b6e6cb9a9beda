"""What a survey notes is there for who goes on with its run."""

from handcart.evaluation.survey_notes import SurveyNotes

NAME = "notes.jsonl"


def test_a_run_that_goes_on_finds_what_was_noted_before(tmp_path):
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


def test_a_disk_that_takes_nothing_changes_nothing(tmp_path):
    notes = SurveyNotes(tmp_path / "missing", NAME)
    notes.add(1.0, {"laid": {}})
    assert notes.until(1.0) == []
