"""The command line as users and programs see it."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from handcart.tools.command_line import all_commands
from tests.tools.conftest import Said

ROOT = Path(__file__).resolve().parents[2]
HEAVY = ("numpy", "networkx", "cv2", "pydantic", "scipy", "matplotlib", "pinocchio", "ompl", "onnxruntime")


def test_help_imports_nothing_heavy() -> None:
    code = (
        "import sys\nfrom handcart.tools.main import main\n"
        "try:\n    main(['--help'])\nexcept SystemExit:\n    pass\n"
        f"print([name for name in {HEAVY!r} if name in sys.modules])"
    )
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT, check=True)
    assert said.stdout.splitlines()[-1] == "[]"
    assert all(name in said.stdout for name in all_commands())


@pytest.mark.parametrize("name", list(all_commands()))
def test_every_subcommand_has_help(handcart: Callable[..., Said], name: str) -> None:
    said = handcart(*name.split(), "--help")
    assert said.status == 0
    assert all_commands()[name][1] in said.out


@pytest.mark.parametrize("what", ["primitives", "backends", "robots", "tasks"])
def test_list(handcart: Callable[..., Said], what: str) -> None:
    expected = {
        "primitives": "MOVE_TO",
        "backends": "kinematic",
        "robots": "librarian",
        "tasks": "return_book",
    }
    assert expected[what] in handcart("list", what).out


def test_list_shows_whole_sentences_of_primitives(handcart: Callable[..., Said]) -> None:
    """The first line of each class's docstring is shown, so its first sentence has to end there."""
    lines = handcart("list", "primitives").out.splitlines()
    assert lines
    assert [line for line in lines if not line.endswith(".")] == []


def test_describe_names_parameters_with_their_meaning(handcart: Callable[..., Said]) -> None:
    said = handcart("describe", "MOVE_TO")
    assert "wait_s" in said.out
    assert "passer-by" in said.out
    assert "RangeSensor" in said.out


def test_describe_ends_with_the_tree_as_the_docs_have_it(handcart: Callable[..., Said]) -> None:
    page = (ROOT / "docs" / "how_to" / "primitives.md").read_text(encoding="utf-8")
    shown = page.partition("`handcart describe INSERT`")[2].split("```")[1].strip()
    assert handcart("describe", "INSERT").out.split("\n\n")[-1].strip() == shown


@pytest.mark.parametrize("name", ["RELEASE", "PICK_UP", "DEPLOY"])
def test_describe_shows_every_tree_of_ours(handcart: Callable[..., Said], name: str) -> None:
    root, *steps = handcart("describe", name).out.split("\n\n")[-1].rstrip().splitlines()
    assert root.startswith("{-} ")
    assert len(steps) >= 5
    assert all(step.startswith("    ") for step in steps)


def test_a_tree_that_asks_the_robot_while_it_is_built_is_not_shown(
    handcart: Callable[..., Said], monkeypatch: pytest.MonkeyPatch
) -> None:
    from py_trees.behaviours import Success

    from handcart.primitives.contract.behaviour_primitive import behaviour_primitive

    kind = behaviour_primitive("Asking", lambda robot, model: Success(f"at {robot.pose.x}"))
    monkeypatch.setattr("handcart.primitives.registry.primitive_class", lambda name: kind)
    said = handcart("describe", "ASKING")
    assert said.status == 0
    assert said.out.partition("writes: nothing\n")[2].lstrip().startswith("causes of")  # no tree follows


@pytest.mark.parametrize("kind", ["task", "robot", "world", "places", "catalogue"])
def test_schema_is_json(handcart: Callable[..., Said], kind: str) -> None:
    schema = json.loads(handcart("schema", kind).out)
    assert schema["$schema"]
    ways = [schema["$defs"][item["$ref"].rpartition("/")[2]] for item in schema.get("anyOf", ())]
    assert all("format" in way["properties"] for way in ways or [schema])
    assert len(ways) == (2 if kind == "task" else 0)  # written, and generated from conditions


@pytest.mark.parametrize("ending", ["png", "pdf"])
def test_draw_as_picture(handcart: Callable[..., Said], tmp_path: Path, ending: str) -> None:
    out = tmp_path / f"network.{ending}"
    assert handcart("draw", ROOT / "tasks/drive_map/task.yaml", "-o", out).status == 0
    assert out.read_bytes()[:4] in (b"\x89PNG", b"%PDF")


@pytest.mark.parametrize("ending", ["svg", "mmd", "dot"])
def test_draw(handcart: Callable[..., Said], tmp_path: Path, ending: str) -> None:
    out = tmp_path / f"network.{ending}"
    assert handcart("draw", ROOT / "tasks/return_book/task.yaml", "-o", out).status == 0
    assert "slot_known" in out.read_text(encoding="utf-8")


def test_check_as_json_lists_findings(handcart: Callable[..., Said], tmp_path: Path) -> None:
    path = tmp_path / "places.yaml"
    path.write_text("format: handcart-places/1\nplaces: {home: {x_m: 1, y_m: zwei}}\n", encoding="utf-8")
    said = handcart("check", path, "--json")
    assert said.status == 2
    findings = json.loads(said.out)["findings"]
    assert {
        (finding["line"], "y_m" in finding["message"] or finding["column"] > 1) for finding in findings
    } == {(2, True)}


def test_do_runs_one_primitive_and_tells_its_outcome(handcart: Callable[..., Said]) -> None:
    said = handcart("do", "MODIFY", "place=shelf_1")
    assert said.status == 0
    assert said.out.startswith("Success")
    said = handcart("do", "INSERT", "shelf=shelf_1")
    assert said.status == 3
    assert said.out.startswith("Fail: the hand is empty; it must hold something")


@pytest.mark.slow
def test_do_takes_what_a_task_tells(handcart: Callable[..., Said]) -> None:
    field = ROOT / "tasks" / "deploy_field"
    said = handcart("do", "DEPLOY", "target=1", "--knowledge", field / "task.yaml", "--start", "")
    assert said.out.startswith("Fail: the arm doesn't reach the target from here")
    said = handcart("do", "DEPLOY", "target=zebra", "--knowledge", field / "task.yaml")
    assert (said.status, "unknown target 'zebra'" in said.err) == (2, True)
    said = handcart("do", "DEPLOY", "target=1")
    assert (said.status, "unknown target '1'; no targets are known" in said.err) == (2, True)
    assert handcart("check", field / "field.yaml").status == 0


def test_the_fixtures_for_users_tests(
    build_rig: Callable[..., Any], do_primitive: Callable[..., Any]
) -> None:
    from handcart.primitives.driving.modify import Modify
    from handcart.primitives.outcomes.outcome import Success

    assert isinstance(build_rig(seed=3).do(Modify(place="shelf_2")), Success)
    assert isinstance(do_primitive(Modify(place="shelf_2"), seed=3), Success)


def test_the_plugin_costs_nothing_unused() -> None:
    code = "import sys, handcart.tools.pytest_plugin\n"
    code += f"print([name for name in {HEAVY!r} if name in sys.modules])"
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT, check=True)
    assert said.stdout.strip() == "[]"


@pytest.mark.slow
def test_run_ends_with_how_it_ended_and_where(handcart: Callable[..., Said], tour: Path) -> None:
    said = handcart("run", tour, "--runs", tour.parent / "runs")
    assert said.status == 0
    folder = tour.parent / "runs" / f"{tour.stem}-0"
    assert said.out == f"Success in situation at_shelf; see {folder}\n"
    assert "1. MOVE_TO: at_home to at_shelf: Success" in said.err
    assert (folder / "journal.jsonl").is_file()


@pytest.mark.slow
def test_run_as_json(handcart: Callable[..., Said], tour: Path) -> None:
    said = handcart("run", tour, "--runs", tour.parent / "runs", "--seed", 5, "--json")
    report = json.loads(said.out.splitlines()[-1])
    fields = (
        "outcome situation reason actions fails replans sim_time_s wall_time_s seed backend run_dir metrics"
    )
    assert set(fields.split()) <= report.keys()
    assert (said.status, report["outcome"], report["seed"], report["backend"]) == (
        0,
        "Success",
        5,
        "kinematic",
    )


def test_a_goal_that_no_way_leads_to_is_status_3(handcart: Callable[..., Said], tour: Path) -> None:
    text = tour.read_text(encoding="utf-8").replace("{do: MOVE_TO,", "{do: INSERT, attempts: 1,")
    tour.write_text(text.replace("place: shelf_3", "shelf: shelf_3"), encoding="utf-8")
    said = handcart("run", tour, "--runs", tour.parent / "runs")
    assert said.status == 3
    assert said.out.startswith("Fail in situation at_home: ")


@pytest.mark.slow
def test_an_interrupt_stops_with_status_130(tour: Path) -> None:
    code = (
        "import os, signal, sys, threading, handcart.tools.terminal.progress\n"
        "from handcart.tools.main import main\n"
        "class Interrupting(handcart.tools.terminal.progress.Progress):\n"
        "    def event(self, event):\n"
        "        super().event(event)\n"
        "        if type(event).__name__ == 'Started': os.kill(os.getpid(), signal.SIGINT)\n"
        "handcart.tools.terminal.progress.Progress = Interrupting\n"
        "main(sys.argv[1:])\n"
    )
    words = [sys.executable, "-c", code, "run", str(tour), "--runs", str(tour.parent / "runs"), "--json"]
    said = subprocess.run(words, capture_output=True, text=True, cwd=ROOT, check=False)
    assert said.returncode == 130, said.stderr
    assert json.loads(said.stdout.splitlines()[-1])["outcome"] == "Cancelled"


@pytest.mark.slow
def test_run_task_of_a_checkout(tour: Path) -> None:
    (tour.parent / "runs").write_text("no folder", encoding="utf-8")
    words = [str(ROOT / "tools" / "run_task"), str(tour), "--runs", str(tour.parent / "runs")]
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    env = os.environ | {"PATH": path}
    said = subprocess.run(words, capture_output=True, text=True, env=env, check=False)
    assert said.returncode == 2
    assert "is not a folder" in said.stderr


def test_a_fault_of_our_own_is_status_5(
    handcart: Callable[..., Said], monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(kind: str) -> None:
        raise ZeroDivisionError

    monkeypatch.setattr("handcart.tools.checks.file_kinds.model_of", broken)
    said = handcart("schema", "task")
    assert said.status == 5
    assert "ZeroDivisionError" in said.err
    assert "a fault in handcart" in said.err
