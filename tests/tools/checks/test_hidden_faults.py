"""All faults at once, also those behind a fault of YAML, and those of files that are read later."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from handcart.files.errors import FileError, Finding
from handcart.files.yaml.yaml_document import parse_document, reading_past

Lines = Callable[..., list[str]]


@pytest.fixture
def refused(handcart: Callable[..., Any], tour: Path) -> Lines:
    """Changes files of a task, given as name, old and new text, and returns what a command refuses."""

    def lines(command: str, *changes: tuple[str, str, str]) -> list[str]:
        for name, old, new in changes:
            text = (tour.parent / name).read_text(encoding="utf-8")
            assert old in text
            (tour.parent / name).write_text(text.replace(old, new, 1), encoding="utf-8")
        said = handcart(command, tour)
        assert said.status == 2
        found = [line.replace(f"{tour.parent}/", "") for line in said.err.splitlines()]
        return [line for line in found if not line.startswith(("checking ", "loading "))]

    return lines


@pytest.mark.parametrize("command", ["check", "run"])
def test_a_duplicate_key_hides_no_other_fault(refused: Lines, command: str) -> None:
    one, two, three = refused(
        command,
        ("tour.yaml", "start: at_home\n", "start: at_home\nstart: at_home\n"),
        ("tour.yaml", "title", "titel"),
        ("tour.yaml", "cost_s: 30", "cost_s: -1"),
    )
    assert one.startswith("tour.yaml:2:1: unknown key 'titel'; did you mean 'title'?")
    assert two == "tour.yaml:7:1: the key 'start' is here again, first on line 6; allowed: once"
    assert three.startswith("tour.yaml:11:56: cost_s is -1; ")


@pytest.mark.parametrize("command", ["check", "run"])
def test_faults_of_all_files_are_reported_together(refused: Lines, command: str) -> None:
    changes = (
        ("tour.yaml", "cost_s: 30", "cost_s: -1"),
        ("map.yaml", "resolution:", "resolution: -1 #"),
        ("places.yaml", "x_m:", "x_mm:"),
        ("world.yaml", "start: {x_m:", "start: {x_m: .nan, x_mm:"),
    )
    found = [line.partition(": ")[0] for line in refused(command, *changes)]
    files = [place.partition(":")[0] for place in found]
    assert {"map.yaml", "places.yaml", "tour.yaml", "world.yaml"} == set(files)
    assert len(set(found)) == len(found)  # .nan is no second fault as a text that should be a number


def test_a_duplicate_key_alone_is_one_finding(refused: Lines) -> None:
    (line,) = refused("check", ("tour.yaml", "start: at_home\n", "start: at_home\nstart: at_home\n"))
    assert line == "tour.yaml:7:1: the key 'start' is here again, first on line 6; allowed: once"


def test_reading_past_a_fault_ends_with_its_context() -> None:
    passed: list[Finding] = []
    with reading_past(passed):
        assert parse_document(b"a: 1\na: 2\nb: .nan\n", "f.yaml").data == {"a": 1, "b": ".nan"}
    assert [finding.line for finding in passed] == [2, 3]
    with pytest.raises(FileError, match=r"f\.yaml:2:1: the key 'a' is here again"):
        parse_document(b"a: 1\na: 2\nb: .nan\n", "f.yaml")


def test_syntax_that_cannot_be_read_is_not_passed() -> None:
    with reading_past([]), pytest.raises(FileError, match=r"f\.yaml:2:1: a bracket is opened"):
        parse_document(b"a: [1\n", "f.yaml")


@pytest.mark.parametrize("repeated", ["{all: places}", "[desk, {parameter: nothing}]"])
def test_a_repeat_over_unknown_elements_hides_no_other_name(
    handcart: Callable[..., Any], tmp_path: Path, repeated: str
) -> None:
    source = Path(__file__).resolve().parents[3] / "tasks" / "drive_map" / "task.yaml"
    text = source.read_text(encoding="utf-8").replace("do: MOVE_TO,", "do: MOVE_TOO,", 1)
    text = text.replace("{all: places}", repeated).replace("robot: librarian", "robot: libarian")
    (tmp_path / "task.yaml").write_text(text, encoding="utf-8")
    said = handcart("check", tmp_path / "task.yaml").err
    assert "unknown robot 'libarian'" in said
    assert said.count("unknown primitive 'MOVE_TOO'") == 1
    assert "missing file 'places.yaml'" in said
