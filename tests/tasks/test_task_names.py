"""Tasks and robots by name, those of other packages included."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from handcart.backends.description.robot_names import SHIPPED_FOLDER, named_robots, robot_path
from handcart.backends.loading.robot_loading import load_robot
from handcart.files.errors import FileError
from handcart.files.plugins import broken_plugin_folders
from handcart.tasks.task_names import named_tasks, task_path

POINTS = """\
[handcart.tasks]
mylab = mylab.jobs
gone = not_installed.jobs
[handcart.robots]
mylab = mylab.machines
"""


@pytest.fixture
def mylab(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An installed package that brings a task and a robot."""
    jobs, machines = tmp_path / "mylab" / "jobs", tmp_path / "mylab" / "machines"
    for folder in (jobs / "patrol", machines / "tiny"):
        folder.mkdir(parents=True)
    (tmp_path / "mylab" / "__init__.py").write_text("", encoding="utf-8")
    (jobs / "patrol" / "task.yaml").write_text("title: Patrol\n", encoding="utf-8")
    for source in (SHIPPED_FOLDER / "cart").glob("*.*"):
        (machines / "tiny" / source.name).write_bytes(source.read_bytes())
    (machines / "tiny" / "fast.yaml").write_bytes((SHIPPED_FOLDER / "cart" / "robot.yaml").read_bytes())
    info = tmp_path / "mylab-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: mylab\nVersion: 1.0\n", encoding="utf-8")
    (info / "entry_points.txt").write_text(POINTS, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "mylab", raising=False)
    return tmp_path / "mylab"


def test_shipped_tasks_have_names() -> None:
    assert {"return_book", "stack_blocks", "drive_map"} <= set(named_tasks())
    assert task_path("return_book") == SHIPPED_FOLDER.parents[1] / "tasks" / "return_book" / "task.yaml"


def test_unknown_task_name_gets_nearest_name() -> None:
    with pytest.raises(FileError, match=r"'return_book'.*or the path of a task file"):
        task_path("retrun_book")


def test_existing_path_wins_over_task_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("return_book").write_text("mine", encoding="utf-8")
    assert task_path("return_book") == Path("return_book")


@pytest.mark.parametrize("given", ["missing.yaml", "x" * 300])
def test_other_paths_are_left_to_whoever_opens_them(given: str) -> None:
    assert task_path(given) == Path(given)


def test_tasks_of_another_package_have_names(mylab: Path) -> None:
    assert task_path("mylab/patrol") == mylab / "jobs" / "patrol" / "task.yaml"
    (message,) = broken_plugin_folders("handcart.tasks")
    assert "'gone' of handcart.tasks names the package 'not_installed.jobs'" in message


def test_robots_of_another_package_have_names(mylab: Path) -> None:
    assert robot_path("mylab/tiny/fast") == mylab / "machines" / "tiny" / "fast.yaml"
    assert load_robot("mylab/tiny").drive.kind == load_robot("cart").drive.kind
    assert robot_path("cart") == SHIPPED_FOLDER / "cart" / "robot.yaml"


def test_no_package_replaces_a_shipped_robot(mylab: Path) -> None:
    info = mylab.parent / "mylab-1.0.dist-info" / "entry_points.txt"
    info.write_text("[handcart.robots]\ntoyama = mylab.machines\n", encoding="utf-8")
    (mylab / "machines" / "tiny").rename(mylab / "machines" / "h1")
    assert named_robots()["toyama/h1"] == SHIPPED_FOLDER / "toyama" / "h1.yaml"
