"""Tutorials work as pasted: their files are written and their commands run, in order, in an empty folder.

A block with a caption is a file. A command whose line ends in `# status N` exits with N.
"""

from __future__ import annotations

import re
import shlex
import subprocess
from pathlib import Path

import pytest
import typer

from handcart.files.models.loading import load_document
from handcart.files.yaml.yaml_document import read_document
from handcart.tools.checks.file_kinds import model_of
from handcart.tools.command_line import LazyGroup, app
from tests.tutorials.tutorial_steps import TUTORIALS, carry_out, steps, write_file

FEWER = {"--instants 2": "--instants 1", "--trials 2": "--trials 1"}
"""Fewer of what is only counted."""


@pytest.mark.slow
@pytest.mark.parametrize("page", TUTORIALS)
def test_tutorial_works_as_pasted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, page: str) -> None:
    monkeypatch.chdir(tmp_path)
    done = 0
    running: list[subprocess.Popen[bytes]] = []
    try:
        for path, text in steps(page):
            if path:
                write_file(tmp_path, path, text)
                continue
            for more, fewer in FEWER.items():
                text = text.replace(more, fewer)
            status, expected = carry_out(text, tmp_path, monkeypatch, running)
            assert status == expected, text
            done += 1
    finally:
        for process in running:
            process.kill()
            process.wait()
    assert done >= 3


@pytest.mark.parametrize("page", TUTORIALS)
def test_commands_of_a_tutorial_are_understood(page: str) -> None:
    group = typer.main.get_command(app)
    assert isinstance(group, LazyGroup)
    for line in (text for path, text in steps(page) if not path and text.startswith("handcart ")):
        with group.make_context("handcart", [], resilient_parsing=True) as context:
            name, command, words = group.resolve_command(context, shlex.split(line, comments=True)[1:])
            command.make_context(name, [word for word in words if word != "&"], parent=context)


@pytest.mark.parametrize("page", TUTORIALS)
def test_files_of_a_tutorial_have_known_keys(tmp_path: Path, page: str) -> None:
    for path, text in steps(page):
        declared = re.match(r"format: handcart-(\w+)/1", text)
        if path and declared and declared[1] != "task":  # whose values may come from its parameters
            write_file(tmp_path, path, text)
            load_document(read_document(tmp_path / path), model_of(declared[1]))
