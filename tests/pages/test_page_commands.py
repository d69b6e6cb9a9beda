"""Commands and snippets of the pages in docs/ work: every command is run, or its reason is listed."""

from __future__ import annotations

import ast
import json
import shlex
import shutil
from pathlib import Path

import pytest
import typer
from ruamel.yaml import YAML

from handcart.tools.command_line import LazyGroup, app
from tests.benchmark_help import benchmark_helps
from tests.pages.page_commands import OWN_TESTS, ROOT, command_lines, pages, shown_files, snippets
from tests.tutorials.tutorial_steps import carry_out, write_file

PREPARED = {
    "docs/how_to/explain.md": [
        "run tasks/return_book/task.yaml",
        "run tasks/return_book/task.yaml --seed 1",
    ],
    "docs/how_to/report.md": [
        "run tasks/return_book/task.yaml --no-report",
        "campaign tasks/drive_map/task.yaml --robot cart --trials 2 --jobs 1 --out tour",
    ],
    "docs/how_to/campaigns.md": [
        "campaign tasks/drive_map/task.yaml --robot cart --trials 2 --jobs 1 --out before",
        "campaign tasks/drive_map/task.yaml --robot cart --trials 2 --jobs 1 --out after",
    ],
    "docs/how_to/objects.md": [],
    "docs/how_to/doors.md": [],
    "docs/how_to/conditions.md": [],
    "docs/how_to/explore.md": [],
    "docs/how_to/export.md": [],
    "docs/how_to/interchange.md": [],
    "docs/how_to/locate.md": [],
    "docs/how_to/new.md": [],
    "docs/how_to/obstacles.md": [],
    "docs/how_to/people.md": [],
    "docs/how_to/ros2.md": [],
    "docs/explanation/stack_blocks.md": [],
}
"""Pages that are run here, with the commands that make what they assume is there."""

FIRST_RUN = "a command of the tutorial first_run.md: tests/tutorials/test_tutorials.py"
NOT_RUN = {
    "README.md": "its commands are what .ci/run begins with",
    "docs/index.md": "its command is the first one of .ci/run",
    "handcart console": "a server: tests/tools/console",
    "handcart node": "rclpy: tests/tools/node",
    "handcart view": "a server: tests/evaluation/viewing/view",
    "handcart bench": "a server: tests/tools/hardware/test_bench.py",
    "handcart run tasks/stack_blocks/task.yaml --view": "a server: tests/evaluation/viewing/view",
    "handcart activity": "an extra: tests/evaluation/activities",
    "handcart run shelving/task.yaml": "an extra: tests/evaluation/activities",
    "python -m benchmarks.objects.activities": "an extra: tests/evaluation/activities",
    "docs/explanation/outcomes.md handcart make-library --seed 7 --blocked way_around --out lib7": FIRST_RUN,
    "docs/explanation/outcomes.md handcart run tasks/return_book/task.yaml --seed 7 --set": FIRST_RUN,
    "docs/explanation/outcomes.md handcart explain runs/return_book-7": FIRST_RUN,
    "docs/how_to/hardware.md": "the tutorial of hardware runs these on a bench",
    "docs/how_to/ros2.md handcart bringup": "takes long: tests/evaluation/bringup/ros",
    "docs/how_to/ros2.md handcart robot": "rclpy: tests/backends/ros2/test_on_the_wire.py",
    "docs/how_to/ros2.md handcart check": "rclpy: tests/backends/ros2/test_on_the_wire.py",
    "docs/how_to/ros2.md handcart run drive_map --backend": "rclpy: tests/backends/ros2/test_on_the_wire.py",
    "docs/how_to/localize.md": "names logs of the reader's: tests/tools/test_localize.py",
    "docs/how_to/map.md": "names logs of the reader's: tests/tools/maps",
    "handcart campaign tasks/drive_map/task.yaml --robot cart --level fitted": (
        "learns from 20 trials: tests/tools/campaigns/test_fitted.py"
    ),
    "docs/explanation/track_seam.md": "names files of the reader's: tests/tools/seam",
    "docs/explanation/deploy_sensors.md": "17 to 200 sensors: tests/tasks runs these files",
    "docs/explanation/stack_blocks.md handcart run tasks/stack_blocks": "tests/tasks runs these files",
    "docs/explanation/stack_blocks.md handcart run tasks/build_fence": "tests/tasks runs these files",
    "docs/explanation/stack_blocks.md handcart campaign": "20 trials of physics: tests/tasks builds a tower",
    "docs/explanation/stack_blocks.md handcart wall toyama/h1 tasks/build_wall/drawing.yaml --map": (
        "tests/tools/blocks/test_wall.py plans the same wall"
    ),
    "docs/explanation/stack_blocks.md handcart run wall": "tests/tasks builds walls",
    "docs/reference/makers_robots.md": "packages of 131 MB: tests/tools/checks/test_robot_table.py",
    "docs/reference/mutation.md": "written with records of hours: tests/test_mutation.py",
    "docs/reference/tasks.md": "a run that goes on: tests/networks/operator",
}
"""Why a command is not run here, by its page, its beginning, or both."""

FEWER = {
    "--worlds 9": "--worlds 1",
    "--runs 4": "--runs 1",
    "--trials 1000000": "--trials 10000",
    "--trials 4": "--trials 2 --jobs 1",
    "--trials 20 --jobs 2": "--trials 2 --jobs 1",
    "--population 4": "--population 2",
    "drive_map/task.yaml --robot cart": "drive_map/task.yaml --robot cart --set tour=[desk]",
    "start=unknown": "start=unknown --set tour=[desk]",
    "--seeds 2": "--seeds 1",
    "--persons pulls nobody": "--persons nobody",
}
"""Fewer of what is only counted."""


def reason_not_run(page: str, line: str) -> str:
    """Return why a command of a page is not run by this file; empty if it is."""
    if page in OWN_TESTS:
        return OWN_TESTS[page]
    if "--cluster" in line:
        return "a scheduler of its own: tests/evaluation/campaigns/test_cluster.py"
    found = [why for start, why in NOT_RUN.items() if f"{page} {line}".startswith(start)]
    found += [why for start, why in NOT_RUN.items() if line.startswith(start)]
    return found[0] if found else ""


@pytest.mark.parametrize("page", pages())
def test_page_commands_are_run_or_have_a_reason(page: str) -> None:
    unexplained = [line for line in command_lines(page) if not reason_not_run(page, line)]
    assert not unexplained or page in PREPARED
    named = {
        word for line in command_lines(page) for word in reason_not_run(page, line).split() if "/" in word
    }
    assert [name for name in named if name.startswith("tests/") and not (ROOT / name).exists()] == []


@pytest.mark.parametrize("page", [page for page in pages() if command_lines(page)])
def test_page_commands_are_understood(page: str) -> None:
    group = typer.main.get_command(app)
    assert isinstance(group, LazyGroup)
    for line in command_lines(page):
        if line.startswith("handcart "):
            with group.make_context("handcart", [], resilient_parsing=True) as context:
                name, command, words = group.resolve_command(context, shlex.split(line)[1:])
                command.make_context(name, [word for word in words if word != "&"], parent=context)


@pytest.mark.slow
@pytest.mark.parametrize("page", PREPARED)
def test_page_works_as_pasted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, page: str) -> None:
    monkeypatch.chdir(tmp_path)
    shutil.copytree(ROOT / "tasks", tmp_path / "tasks")  # a page may change a task, as `learn --write` does
    (tmp_path / "benchmarks").symlink_to(ROOT / "benchmarks")
    before = task_files()
    for name, text in shown_files(page):
        write_file(tmp_path, name, text)
    lines = [line for line in command_lines(page) if not reason_not_run(page, line)]
    for line in [*(f"handcart {words}" for words in PREPARED[page]), *lines]:
        for more, fewer in FEWER.items():
            line = line.replace(more, fewer)
        assert carry_out(line, tmp_path, monkeypatch, [])[0] == 0, line
    assert task_files() == before, "a command of the page changed the checkout's own files"


def task_files() -> dict[Path, bytes]:
    """Contents of the checkout's task files."""
    return {path: path.read_bytes() for path in sorted((ROOT / "tasks").rglob("*.yaml"))}


@pytest.mark.slow
def test_benchmarks_in_pages_know_the_options() -> None:
    lines = {
        line for page in pages() for line in command_lines(page) if line.startswith("python -m benchmarks")
    }
    helps = benchmark_helps({shlex.split(line)[2] for line in lines})
    for line in sorted(lines):
        _, _, module, *words = shlex.split(line)
        assert helps[module].status == 0, line
        shown = helps[module].text
        assert [word for word in words if word.startswith("--") and word not in shown] == [], line


@pytest.mark.parametrize("page", pages())
def test_page_snippets_are_well_formed(page: str) -> None:
    for snippet in snippets(page):
        where = f"{page}:{snippet.line}"
        if snippet.kind == "python":
            ast.parse(snippet.text, where)
        elif snippet.kind == "yaml":
            assert list(YAML(typ="safe").load_all(snippet.text)), where
        elif snippet.kind == "json":
            assert json.loads(snippet.text) is not None, where
