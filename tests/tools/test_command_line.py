"""The command line as users and programs see it."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tools.handcart import COMMANDS

ROOT = Path(__file__).resolve().parents[2]
HEAVY = ("numpy", "networkx", "cv2", "pydantic", "scipy", "matplotlib", "pinocchio", "ompl", "onnxruntime")


def test_help_imports_nothing_heavy() -> None:
    code = (
        "import sys\nfrom tools.handcart import main\n"
        "try:\n    main(['--help'])\nexcept SystemExit:\n    pass\n"
        f"print([name for name in {HEAVY!r} if name in sys.modules])"
    )
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT, check=True)
    assert said.stdout.splitlines()[-1] == "[]"
    assert all(name in said.stdout for name in COMMANDS)


@pytest.mark.parametrize("name", list(COMMANDS))
def test_every_subcommand_has_help(handcart: Callable[..., Any], name: str) -> None:
    said = handcart(name, "--help")
    assert said.status == 0
    assert COMMANDS[name][2] in said.out


@pytest.mark.parametrize("what", ["primitives", "backends", "robots", "tasks"])
def test_list(handcart: Callable[..., Any], what: str) -> None:
    expected = {
        "primitives": "MOVE_TO",
        "backends": "kinematic",
        "robots": "librarian",
        "tasks": "return_book",
    }
    assert expected[what] in handcart("list", what).out


def test_describe_names_parameters_with_their_meaning(handcart: Callable[..., Any]) -> None:
    said = handcart("describe", "MOVE_TO")
    assert "wait_s" in said.out
    assert "passer-by" in said.out
    assert "RangeSensor" in said.out


@pytest.mark.parametrize("kind", ["task", "robot", "world", "places", "catalogue"])
def test_schema_is_json(handcart: Callable[..., Any], kind: str) -> None:
    told = json.loads(handcart("schema", kind).out)
    assert told["$schema"]
    assert "format" in told["properties"]


@pytest.mark.parametrize("ending", ["svg", "mmd", "dot"])
def test_draw(handcart: Callable[..., Any], tmp_path: Path, ending: str) -> None:
    out = tmp_path / f"network.{ending}"
    assert handcart("draw", ROOT / "tasks/return_book/task.yaml", "-o", out).status == 0
    assert "slot_known" in out.read_text(encoding="utf-8")


def test_check_as_json_lists_findings(handcart: Callable[..., Any], tmp_path: Path) -> None:
    path = tmp_path / "places.yaml"
    path.write_text("format: handcart-places/1\nplaces: {home: {x_m: 1, y_m: zwei}}\n", encoding="utf-8")
    said = handcart("check", path, "--json")
    assert said.status == 2
    findings = json.loads(said.out)["findings"]
    assert {(each["line"], "y_m" in each["message"] or each["column"] > 1) for each in findings} == {
        (2, True)
    }


def test_do_runs_one_primitive_and_tells_its_outcome(handcart: Callable[..., Any]) -> None:
    said = handcart("do", "MODIFY", "place=shelf_1")
    assert said.status == 0
    assert said.out.startswith("Success")
    said = handcart("do", "MOVE_TO", "place=cellar")
    assert said.status == 3
    assert "no place 'cellar'" in said.out
    assert handcart("do", "MOVE_TO", "plaze=shelf_1").status == 2
    assert handcart("do", "MOVETO").status == 2


def test_teach_keeps_comments_and_refuses_what_the_arm_cant(
    handcart: Callable[..., Any], tmp_path: Path
) -> None:
    robots = ROOT / "backends" / "robots" / "librarian"
    for name in ("robot.yaml", "librarian.urdf"):
        (tmp_path / name).write_bytes((robots / name).read_bytes())
    path = tmp_path / "robot.yaml"
    before = path.read_text(encoding="utf-8")
    assert handcart("teach", "wave", "--robot", path, "--joints", "0,0,1000,0,0,0").status == 2
    assert path.read_text(encoding="utf-8") == before
    assert handcart("teach", "wave", "--robot", path, "--joints", "0,-30,90,0,0,0", "--write").status == 0
    after = path.read_text(encoding="utf-8")
    assert "wave: [0.0, -30.0, 90.0, 0.0, 0.0, 0.0]" in after
    assert [line for line in before.splitlines() if "#" in line] == [
        line for line in after.splitlines() if "#" in line
    ]


def test_the_fixture_for_users_tests(set_stage: Callable[..., Any]) -> None:
    from primitives.modify import Modify
    from primitives.outcome import Success

    assert isinstance(set_stage(seed=3).do(Modify(place="shelf_2")), Success)
