"""Bad input: exit status 2 before anything moves, every error at once, with file, line and column."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from tests.tools.conftest import Said

TASKS = Path(__file__).resolve().parents[3] / "tasks"
TASK = """\
format: handcart-task/1
title: A test
robot: librarian
world: world.yaml
knowledge: {map: map.yaml, places: places.yaml, catalogue: catalogue.yaml, start: home}
start: here
goal: there
situations: {here: {base: home}, there: {base: shelf}}
actions:
  - {do: MOVE_TO, from: here, to: there, cost_s: 30, with: {place: shelf_3, wait_s: 1.0}}
"""


@pytest.fixture
def broken(tmp_path: Path) -> Callable[..., Path]:
    """A task file in a folder with the library's files, with some text replaced."""
    for name in ("world.yaml", "map.yaml", "map.png", "places.yaml", "catalogue.yaml"):
        (tmp_path / name).write_bytes((TASKS / "return_book" / name).read_bytes())

    def write(*changes: tuple[str, str]) -> Path:
        text = TASK
        for old, new in changes:
            assert old in text
            text = text.replace(old, new)
        path = tmp_path / "task.yaml"
        path.write_text(text, encoding="utf-8")
        return path

    return write


def test_the_task_itself_is_right(handcart: Callable[..., Said], broken: Callable[..., Path]) -> None:
    assert handcart("check", broken()).status == 0


@pytest.mark.parametrize(
    ("old", "new", "place", "words"),
    [
        ("MOVE_TO", "MOVE_TOO", ":10:10: ", "did you mean 'MOVE_TO'"),
        ("place: shelf_3", "place: 3", ":10:", "text"),
        ("wait_s: 1.0", "wait_s: 1e9", ":10:", "600"),
        ("wait_s: 1.0", "weit_s: 1.0", ":10:", "did you mean 'wait_s'"),
        ("from: here", "from: hier", ":10:", "did you mean 'here'"),
        ("goal: there", "goal: their", ":7:7: ", "did you mean 'there'"),
        ("to: there", "to: here", ":7:", "reach"),
        ("cost_s: 30", "cost_s: -1", ":10:", "cost_s"),
        ("place: shelf_3", "place: shelf_33", ":10:", "shelf_3"),
        ("robot: librarian", "robot: librarien", "", "librarien"),
        ("map: map.yaml", "map: mop.yaml", "mop.yaml", "mop.yaml"),
        ("robot: librarian", "robot: librarian\nbackend: kinematik", ":4:10: ", "did you mean 'kinematic'"),
    ],
)
def test_one_error_is_told_with_its_place(
    handcart: Callable[..., Said], broken: Callable[..., Path], old: str, new: str, place: str, words: str
) -> None:
    path = broken((old, new))
    said = handcart("run", path, "--runs", path.parent / "runs")
    assert said.status == 2
    assert place in said.err
    assert words in said.err
    assert "Traceback" not in said.err
    assert not (path.parent / "runs").exists()


def test_all_errors_are_told_at_once(handcart: Callable[..., Said], broken: Callable[..., Path]) -> None:
    path = broken(("goal: there", "goal: their"), ("MOVE_TO", "MOVE_TOO"), ("title: A test", "titel: A test"))
    said = handcart("check", path)
    assert said.status == 2
    assert "titel" in said.err
    lines = [line for line in said.err.splitlines() if line.startswith(str(path))]
    assert len(lines) >= 2


def test_a_missing_file_is_told(handcart: Callable[..., Said], tmp_path: Path) -> None:
    said = handcart("run", tmp_path / "nothing.yaml")
    assert said.status == 2
    assert "nothing.yaml" in said.err


def test_t17_a_robot_without_a_needed_capability_is_refused(
    handcart: Callable[..., Said], broken: Callable[..., Path]
) -> None:
    robots = Path(__file__).resolve().parents[3] / "backends" / "robots" / "librarian"
    path = broken(("robot: librarian", "robot: blind.yaml"))
    lines = (robots / "robot.yaml").read_text(encoding="utf-8").split("\n")
    start = next(i for i, line in enumerate(lines) if line.startswith("range_sensor:"))
    end = next(i for i in range(start + 1, len(lines)) if lines[i] and not lines[i].startswith((" ", "#")))
    text = "\n".join(lines[:start] + lines[end:]).replace("localizer: scan", "localizer: odometry")
    (path.parent / "blind.yaml").write_text(text, encoding="utf-8")
    (path.parent / "librarian.urdf").write_bytes((robots / "librarian.urdf").read_bytes())
    said = handcart("run", path, "--runs", path.parent / "runs")
    assert said.status == 2
    assert "RangeSensor" in said.err


def test_an_unknown_backend_and_an_unknown_setting_are_refused(
    handcart: Callable[..., Said], broken: Callable[..., Path]
) -> None:
    said = handcart("run", broken(), "--backend", "kinematik")
    assert (said.status, "did you mean 'kinematic'" in said.err) == (2, True)
    said = handcart("run", TASKS / "return_book" / "task.yaml", "--set", "wait=3")
    assert (said.status, "did you mean 'wait_s'" in said.err) == (2, True)


def test_file_of_unknown_kind_is_rejected_and_a_ros_map_accepted(
    handcart: Callable[..., Said], tmp_path: Path
) -> None:
    (tmp_path / "some.yaml").write_text("image: some.png\n", encoding="utf-8")
    said = handcart("check", tmp_path / "some.yaml")
    assert said.status == 2
    assert "some.yaml:1:1: the key 'format'" in said.err
    said = handcart("check", TASKS / "return_book" / "map.yaml")
    assert said.status == 0
    assert "cells: 470 x 370 of 0.02 m" in said.out


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("rum", "task.yaml"), "did you mean 'run'"),
        (("describe", "MOVETO"), "did you mean 'MOVE_TO'"),
        (("schema", "tusk"), "did you mean 'task'"),
        (("list", "primitive"), "primitives"),
        (("schema", "task", "-o", "no/folder/here.json"), "can't be written"),
        (("draw", str(TASKS / "return_book/task.yaml"), "-o", "no/folder/here.svg"), "can't be written"),
        (("draw", str(TASKS / "return_book/task.yaml"), "-o", "network.gif"), ".svg"),
        (("make-library", "--out", __file__), "is not a folder"),
        (("run", str(TASKS / "return_book/task.yaml"), "--runs", __file__), "is not a folder"),
        (("check", __file__), "invalid YAML"),
        (("do", "MOVETO"), "did you mean 'MOVE_TO'"),
        (("do", "MOVE_TO", "plaze=shelf_1"), "did you mean 'place'"),
        (("do", "MOVE_TO", "place=shelf_1", "wait_s=-5"), "wait_s is -5; allowed: a number from 0 to 600 s"),
        (("do", "MOVE_TO", "place=cellar"), "unknown place 'cellar'"),
        (("do", "MOVE_TO", "place"), "allowed: KEY=VALUE"),
        (("do", "MODIFY", "place=shelf_1", "--start", "cellar"), "cellar"),
        (("do", "MODIFY", "place=shelf_1", "--world", "none.yaml"), "none.yaml:1:1"),
    ],
)
def test_bad_words_are_refused(handcart: Callable[..., Said], words: tuple[str, ...], message: str) -> None:
    said = handcart(*words)
    assert said.status == 2
    assert message in said.err
    assert "Traceback" not in said.err


def test_findings_of_do_name_what_was_typed(handcart: Callable[..., Said]) -> None:
    said = handcart("do", "MOVE_TO", "place=shelf_1", "wait_s=two", "weit_s=3")
    assert said.err.splitlines() == [
        "wait_s=two: wait_s is 'two'; allowed: a number from 0 to 600 s",
        "weit_s=3: unknown key 'weit_s'; did you mean 'wait_s'? "
        "allowed: place, wait_s, reverse, detour, together",
    ]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("urdf: librarian.urdf", "urdf: none.urdf", "missing text file 'none.urdf'"),
        ("urdf: librarian.urdf", "urdf: robot.yaml", "the file is not well-formed"),
        ("joint_6]", "joint_7]", "no movable joint 'joint_7'"),
        ("home: [-", "home: [0, -", "7 angles; allowed: 6"),
        ("home: [-", "home: [-9", "joint_1 can't stand at"),
    ],
)
def test_a_robots_file_is_checked_against_its_urdf(
    handcart: Callable[..., Said], tmp_path: Path, old: str, new: str, message: str
) -> None:
    robots = Path(__file__).resolve().parents[3] / "backends" / "robots" / "librarian"
    text = (robots / "robot.yaml").read_text(encoding="utf-8")
    assert old in text
    (tmp_path / "robot.yaml").write_text(text.replace(old, new, 1), encoding="utf-8")
    (tmp_path / "librarian.urdf").write_bytes((robots / "librarian.urdf").read_bytes())
    said = handcart("check", tmp_path / "robot.yaml")
    assert said.status == 2
    assert message in said.err
    assert said.err.startswith(str(tmp_path / "robot.yaml:"))


@pytest.mark.slow
def test_thresholds_that_free_unknown_cells_are_a_warning(
    handcart: Callable[..., Said], broken: Callable[..., Path]
) -> None:
    import cv2

    path = broken(("place: shelf_3", "place: home"))
    chart = path.parent / "map.png"
    image = cv2.imread(str(chart), cv2.IMREAD_GRAYSCALE)
    assert image is not None
    image[:2, :] = 205
    cv2.imwrite(str(chart), image)
    lines = (
        (path.parent / "map.yaml")
        .read_text(encoding="utf-8")
        .replace("free_thresh: 0.196", "free_thresh: 0.25")
    )
    (path.parent / "map.yaml").write_text(lines, encoding="utf-8")
    said = handcart("run", path, "--runs", path.parent / "runs")
    assert said.status == 0
    assert "unknown cells (grey 205) into free ones" in said.err


@pytest.mark.parametrize("command", ["check", "run", "do"])
def test_a_broken_urdf_is_told_with_its_place(
    handcart: Callable[..., Said], broken: Callable[..., Path], command: str
) -> None:
    robots = TASKS.parent / "backends" / "robots" / "librarian"
    path = broken(("robot: librarian", "robot: mine.yaml"))
    (path.parent / "mine.yaml").write_bytes((robots / "robot.yaml").read_bytes())
    (path.parent / "librarian.urdf").write_text("<robot name='x'><link", encoding="utf-8")
    words = ("MOVE_TO", "place=shelf_3", "--robot", path.parent / "mine.yaml") if command == "do" else (path,)
    said = handcart(command, *words)
    assert said.status == 2
    assert "librarian.urdf:1:17: the file is not well-formed: unclosed token" in said.err
    assert "Traceback" not in said.err


@pytest.mark.parametrize("version", ["handcart-task/2", "handcart-task", "task/1", "7"])
def test_another_version_is_told_with_what_is_allowed(
    handcart: Callable[..., Said], broken: Callable[..., Path], version: str
) -> None:
    """T15"""
    said = handcart("check", broken(("handcart-task/1", version)))
    assert said.status == 2
    assert "task.yaml:1:9: " in said.err
    assert "handcart-task/1" in said.err


def test_a_missing_version_is_told(handcart: Callable[..., Said], broken: Callable[..., Path]) -> None:
    """T15"""
    said = handcart("check", broken(("format: handcart-task/1\n", "")))
    assert said.status == 2
    assert "the key 'format'" in said.err


def test_a_task_whose_world_has_moved_is_refused(
    handcart: Callable[..., Said], broken: Callable[..., Path]
) -> None:
    """T12: by `check`, by `--dry-run` and so before a run."""
    task = broken()
    world = (task.parent / "world.yaml").read_text(encoding="utf-8")
    assert "start: {x_m: " in world
    (task.parent / "world.yaml").write_text(
        world.replace("start: {x_m: ", "start: {x_m: 9"), encoding="utf-8"
    )
    for words in (("check",), ("run", "--dry-run")):
        said = handcart(*words, task)
        assert said.status == 2
        assert "world.yaml:3:8: the robot starts off the map that it is given; allowed: on it" in said.err


def test_misspelled_key_is_named_with_its_place(
    handcart: Callable[..., Said], broken: Callable[..., Path]
) -> None:
    path = broken(("format:", "fromat:"))
    assert "task.yaml:1:1: unknown key 'fromat'; did you mean 'format'?" in handcart("check", path).err
    chart = path.with_name("map.yaml")
    text = chart.read_text(encoding="utf-8")
    chart.write_text(text.replace("resolution", "resolutoin"), encoding="utf-8")
    said = handcart("check", chart)
    assert said.status == 2
    assert "map.yaml:3:1: unknown key 'resolutoin'; did you mean 'resolution'?" in said.err
    assert len(said.err.splitlines()) == 1
