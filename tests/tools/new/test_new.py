"""`handcart new`: written files work as they are, and invalid names write nothing."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from handcart.tools.main import main
from handcart.tools.new.scaffold import KINDS, names_of
from tests.tutorials.tutorial_steps import carry_out


def run(words: list[str]) -> int:
    with pytest.raises(SystemExit) as end:
        main(words)
    return int(end.value.code or 0)


@pytest.mark.parametrize("kind", KINDS)
def test_new_folder_has_no_open_placeholder(tmp_path: Path, kind: str) -> None:
    assert run(["new", kind, "soft_soap", "--out", str(tmp_path / "made")]) == 0
    files = [path for path in (tmp_path / "made").rglob("*") if path.is_file() and path.suffix != ".png"]
    assert len(files) >= 2
    assert [path for path in files if re.search(r"\$\{?\w|NAME", path.read_text(encoding="utf-8"))] == []
    assert [path for path in files if "NAME" in str(path.relative_to(tmp_path))] == []


@pytest.mark.parametrize("name", ["Soap", "soft-soap", "7up", "a__b", "class", "", "a b", "soap_"])
def test_invalid_name_is_refused_and_nothing_is_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str
) -> None:
    assert run(["new", "task", name, "--out", str(tmp_path / "made")]) == 2
    assert f"invalid name {name!r}; allowed: small letters" in capsys.readouterr().err
    assert not (tmp_path / "made").exists()


def test_unknown_kind_names_the_nearest(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["new", "primitiv", "soap"]) == 2
    assert "did you mean 'primitive'?" in capsys.readouterr().err


def test_folder_with_files_is_left_alone(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "mine.txt").write_text("mine")
    assert run(["new", "task", "soap", "--out", str(tmp_path)]) == 2
    assert "allowed: a new or an empty folder" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["mine.txt"]


def test_new_task_and_robot_have_no_findings(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for kind, file in (("task", "task.yaml"), ("robot", "robot.yaml")):
        assert run(["new", kind, f"a_{kind}", "--out", str(tmp_path / kind)]) == 0
        assert run(["check", str(tmp_path / kind / file)]) == 0
        assert "no fault found" in capsys.readouterr().out


FEWER = {"run drive_map": "run drive_map --set tour=[desk]", "--instants 2": "--instants 1"}
"""Fewer of what is only counted."""
OF_ITS_OWN_KIND = "handcart run own_project/objects/task.yaml"
"""Command that is not run in a project: the kind `objects` has the same files."""


def test_objects_of_a_project_are_those_of_their_own_kind() -> None:
    assert ("objects", "objects") in KINDS["project"].parts
    assert KINDS["objects"].parts == (("objects", ""),)
    assert OF_ITS_OWN_KIND in [
        words.replace("$folder", "own_project") for words in KINDS["project"].next_commands
    ]


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_printed_commands_work_one_after_the_other(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], kind: str
) -> None:
    monkeypatch.chdir(tmp_path)
    assert run(["new", kind, f"own_{kind}"]) == 0
    shown = capsys.readouterr().out.partition("Next:\n")[2]
    commands = [line.strip() for line in shown.splitlines() if line.strip()]
    assert len(commands) == len(KINDS[kind].next_commands)
    installs = any(command.startswith("pip ") for command in commands)
    for command in commands:
        if command == OF_ITS_OWN_KIND:
            continue
        for more, fewer in FEWER.items():
            command = command.replace(more, fewer)
        if installs and command.startswith("handcart "):  # a new process: it sees what was installed
            command = command.replace("handcart ", "python -m handcart ", 1)
        assert carry_out(command, tmp_path, monkeypatch, [])[0] == 0, command


def test_names_have_all_forms() -> None:
    names = names_of("soft_soap")
    assert (names["NAME"], names["Name"], names["distribution"]) == ("SOFT_SOAP", "SoftSoap", "soft-soap")
