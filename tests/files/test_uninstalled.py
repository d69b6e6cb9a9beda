"""Names of plugins whose package lies beside a file, and is not installed."""

from __future__ import annotations

from pathlib import Path

import pytest

from handcart.files import uninstalled
from handcart.files.errors import FileError
from handcart.files.uninstalled import not_installed
from handcart.networks.task.task_file import load_task

PROJECT = '[project.entry-points."handcart.primitives"]\nPUSH = "push.push:Push"\n'
TASK = """\
format: handcart-task/1
title: Push
robot: librarian
start: a
goal: b
situations: {a: {}, b: {}}
actions: [{do: PUSH, from: a, to: b, cost_s: 1}]
"""


@pytest.fixture
def task(tmp_path: Path) -> Path:
    """Return a task in a project that declares the primitive PUSH."""
    (tmp_path / "pyproject.toml").write_text(PROJECT, encoding="utf-8")
    path = tmp_path / "tasks" / "push" / "task.yaml"
    path.parent.mkdir(parents=True)
    path.write_text(TASK, encoding="utf-8")
    return path


def test_the_package_that_declares_a_primitive_is_to_be_installed(task: Path) -> None:
    with pytest.raises(FileError) as raised:
        load_task(task)
    assert len(raised.value.findings) == 1
    message = raised.value.findings[0].message
    assert message.startswith("unknown primitive 'PUSH'; allowed: ")
    assert "declares plugins that are not installed (handcart.primitives: PUSH): pip install -e " in message
    assert message.endswith(task.parents[2].name)


def test_installed_packages_are_not_mentioned(task: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(uninstalled, "_is_installed", lambda group, name: True)
    assert not_installed(task) == ""


@pytest.mark.parametrize("content", ["[project", "project = 3", "[project]\nentry-points = [1]", "", "\xff"])
def test_project_files_that_declare_nothing_are_passed_over(tmp_path: Path, content: str) -> None:
    (tmp_path / "pyproject.toml").write_text(content, encoding="latin-1")
    assert not_installed(tmp_path / "task.yaml") == ""
