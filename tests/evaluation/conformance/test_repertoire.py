"""The trials of the kit on a robot follow from the declarations of the domains."""

from __future__ import annotations

from pathlib import Path

import pytest

from handcart.backends.description.robot_names import robot_path
from handcart.evaluation.conformance.faults.repertoire import lacking, repertoire
from handcart.evaluation.conformance.kit import KitSetting, default_robot
from handcart.evaluation.trials.rig import RigFiles
from handcart.networks.task.task_file import load_task
from handcart.primitives.registry import primitive_names
from handcart.tools.main import main

TASKS = Path(__file__).resolve().parents[3] / "tasks"
TRIED = {
    "librarian": "APPROACH CLOSE EXPLORE HAND_OVER INSERT LOCATE LOOK_FOR MODIFY MOVE_ARM MOVE_TO OPEN PICK "
    "PICK_UP PLACE RECOGNIZE RELEASE SEARCH STOW",
    "toyama": "CALIBRATE_CAMERA CALIBRATE_SUSPENSION FIXATE MOVE_TO PICK_UP_BLOCK STACK",
    "atrv": "DIVIDE MOVE_TO TRACK",
    "el_verde": "DEPLOY MODIFY MOVE_TO ORIENT STAND",
}
"""On which shipped robot faults are injected into which primitives."""


@pytest.mark.parametrize("robot", TRIED)
def test_faults_are_tried_in_all_that_a_robot_is_made_for(robot: str) -> None:
    assert KitSetting("kinematic", robot).tried() == sorted([*TRIED[robot].split(), "REACH"])


def test_faults_are_tried_in_every_registered_primitive() -> None:
    every = {name for names in TRIED.values() for name in names.split()}
    assert every == set(primitive_names())


@pytest.mark.parametrize(("backend", "keys"), [("pybullet", ("doors",)), ("mujoco", ()), ("kinematic", ())])
def test_engine_without_joints_of_the_world_lacks_doors(backend: str, keys: tuple[str, ...]) -> None:
    assert lacking(TASKS / "open_drawer" / "task.yaml", backend) == keys


@pytest.mark.slow
def test_doors_are_left_out_by_name_where_an_engine_has_none(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as end:
        main(["conformance", "--backend", "pybullet", "--primitive", "OPEN"])
    assert end.value.code == 2
    assert "'OPEN': pybullet simulates no doors" in " ".join(capsys.readouterr().err.split())


@pytest.mark.slow
def test_a_variant_is_tried_in_what_its_robot_is_made_for() -> None:
    assert KitSetting("kinematic", "toyama/h1").tasks == KitSetting("kinematic", "toyama").tasks


@pytest.mark.slow
def test_unknown_robot_is_tried_in_all_its_capabilities() -> None:
    tasks = KitSetting("kinematic", "cart").tasks
    assert [f"{path.parent.name}/{path.name}" for path in tasks] == [
        "drive_map/task.yaml",
        "drive_map/locate.yaml",
        "drive_map/explore.yaml",
    ]


@pytest.mark.slow
def test_a_robot_of_somebodys_own_is_tried_in_all_that_it_can_do() -> None:
    librarian = str(robot_path("librarian"))
    tasks = repertoire(librarian, {"robot": librarian}, "kinematic")
    names = [path.parent.name for path in tasks]
    assert sorted(names) == ["drive_map"] * 3 + ["fetch_and_carry"] * 3 + [
        "open_drawer",
        "return_book",
        "return_books",
    ]


@pytest.mark.slow
def test_checks_are_made_where_the_first_task_is_done() -> None:
    assert KitSetting("kinematic").bench.files == RigFiles()
    files = KitSetting("kinematic", "toyama").bench.files
    assert files.world == TASKS / "stack_blocks" / "unload_world.yaml"
    assert files.start == "stacking"
    assert KitSetting("kinematic", "el_verde").bench.files == RigFiles()


def test_own_task_replaces_the_shipped_ones() -> None:
    own = TASKS / "drive_map" / "task.yaml"
    assert default_robot([own]) == "librarian"
    setting = KitSetting("kinematic", "cart", own_tasks=[own])
    assert (setting.tasks, setting.tried()) == ((own.resolve(),), ["MODIFY", "MOVE_TO", "REACH"])
    assert setting.bench.files == RigFiles.of(load_task(own, {"robot": "cart"}))


def test_own_task_with_a_fault_is_refused_before_a_trial(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for path in (TASKS / "drive_map").iterdir():
        if path.is_file():
            (tmp_path / path.name).write_bytes(path.read_bytes())
    places = tmp_path / "places.yaml"
    places.write_text(places.read_text(encoding="utf-8").replace("x_m: 2.0", "x_m: 90.0"), encoding="utf-8")
    with pytest.raises(SystemExit) as end:
        main(["conformance", "--rehearse", str(tmp_path / "task.yaml"), "--robot", "cart"])
    assert end.value.code == 2
    assert "places.yaml:5:" in capsys.readouterr().err
