"""Trees, machines and models of other programs: read, written, damaged."""

from __future__ import annotations

import json
import random
import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import py_trees
import pytest
from pydantic import ConfigDict

from benchmarks.deciding.foreign_trees import machine_files, tree_files
from benchmarks.deciding.interchange import ATTACK_FILES, hostile, imported, written
from benchmarks.deciding.lost_constructs import lost_in_machine, lost_in_tree
from handcart.backends.robot.robot import Robot
from handcart.evaluation.interchange.bt_export import parts_of_tree, tree_text
from handcart.evaluation.interchange.exporting import FORMAT_WRITERS, exported
from handcart.evaluation.interchange.importing import import_file
from handcart.evaluation.interchange.jani import GAVE_UP_NAME, model_text
from handcart.evaluation.interchange.py_trees_export import parts_of_py_tree, py_tree
from handcart.evaluation.interchange.py_trees_import import import_py_tree
from handcart.evaluation.interchange.task_draft import TooLargeDraft, yaml_text
from handcart.evaluation.interchange.task_parts import TaskParts
from handcart.evaluation.interchange.xml_tree import parse_xml_tree
from handcart.files.errors import FileError
from handcart.networks.graph.network import ActionNetwork
from handcart.networks.graph.route import RunDecisions
from handcart.networks.task.task_file import Task, load_task
from handcart.primitives.contract.action_primitive import ActionPrimitive, Periods
from handcart.primitives.knowledge.world_model import ModelView
from handcart.primitives.outcomes.outcome import Success
from handcart.tasks.task_names import named_tasks

TASKS = named_tasks()
Import = Callable[[str, str], "Task"]


class Anything(ActionPrimitive):
    """A primitive with any parameters."""

    model_config = ConfigDict(extra="allow")

    def motion(self, robot: Robot, model: ModelView) -> Periods:
        return
        yield


@pytest.fixture
def read(tmp_path: Path) -> Import:
    """Imports a text, and loads the task that was written from it."""

    def loaded(name: str, text: str) -> Task:
        (tmp_path / name).write_text(text)
        data = {"robot": "librarian", **import_file(tmp_path / name).data}
        data["actions"] = [{**row, "with": {}} for row in data["actions"]]
        (tmp_path / "lib").mkdir(exist_ok=True)
        (tmp_path / "lib" / "task.yaml").write_text(yaml_text(data))
        return load_task(tmp_path / "lib" / "task.yaml", None, lambda name: Anything)

    return loaded


def leaves(network: ActionNetwork, ends: Mapping[str, str] | None = None) -> tuple[list[str], str]:
    """Decide a run whose leaves end as given, F or S for each start; return the leaves and the end."""
    left = {name: list(words) for name, words in (ends or {}).items()}
    route, found = RunDecisions(network), list[str]()
    while not route.arrived and (route.planned or not hasattr(route.plan(), "explanation")):
        if route.arrived:
            break
        action = route.next
        name = action.source.split(" ")[0]
        found.append(name)
        failed = bool(left.get(name)) and left[name].pop(0) == "F"
        if failed:
            route.failed("so")
        else:
            route.took(Success())
    return found, route.situation


def tree(body: str) -> str:
    head = '<root BTCPP_format="4" main_tree_to_execute="t">'
    return f'{head}<BehaviorTree ID="t">{body}</BehaviorTree></root>'


@pytest.mark.parametrize(
    ("body", "ends", "expected"),
    [
        ("<Sequence><A/><B/></Sequence>", {}, "AB"),
        ("<Fallback><A/><B/></Fallback>", {"A": "F"}, "AB"),
        ("<Fallback><A/><B/></Fallback>", {}, "A"),
        ("<Sequence><Inverter><A/></Inverter><B/></Sequence>", {"A": "F"}, "AB"),
        ("<Sequence><ForceSuccess><A/></ForceSuccess><B/></Sequence>", {"A": "F"}, "AB"),
        ('<RetryUntilSuccessful num_attempts="3"><A/></RetryUntilSuccessful>', {"A": "FF"}, "AAA"),
        ('<RetryUntilSuccessful num_attempts="-1"><A/></RetryUntilSuccessful>', {"A": "F" * 30}, "A" * 31),
        ('<Sequence><Repeat num_cycles="3"><A/></Repeat><B/></Sequence>', {}, "AAAB"),
        ('<RecoveryNode number_of_retries="2"><A/><B/></RecoveryNode>', {"A": "FF"}, "ABABA"),
        ("<IfThenElse><A/><B/><C/></IfThenElse>", {"A": "F"}, "AC"),
        ("<IfThenElse><A/><B/><C/></IfThenElse>", {}, "AB"),
        ("<Sequence><AlwaysSuccess/><Action ID='A'/></Sequence>", {}, "A"),
    ],
)
def test_trees_do_the_leaves_that_they_would_tick(
    read: Import, body: str, ends: dict[str, str], expected: str
) -> None:
    assert leaves(read("t.xml", tree(body)).network, ends) == (list(expected), "done")


@pytest.mark.parametrize(
    ("body", "ends", "expected"),
    [
        ("<Sequence><A/><B/></Sequence>", {"A": "F"}, "A"),
        ('<RetryUntilSuccessful num_attempts="2"><A/></RetryUntilSuccessful>', {"A": "FF"}, "AA"),
        ('<RecoveryNode number_of_retries="2"><A/><B/></RecoveryNode>', {"A": "F", "B": "F"}, "AB"),
    ],
)
def test_trees_that_fail_end_in_failed(read: Import, body: str, ends: dict[str, str], expected: str) -> None:
    assert leaves(read("t.xml", tree(body)).network, ends) == (list(expected), "failed")


def test_subtrees_get_their_ports(tmp_path: Path) -> None:
    path = tmp_path / "t.xml"
    part = '<BehaviorTree ID="p"><Go place="{to}" speed="0.5"/></BehaviorTree>'
    path.write_text(tree('<SubTree ID="p" to="hall"/>').replace("</root>", f"{part}</root>"))
    found = import_file(path)
    assert found.data["actions"][0]["with"] == {"place": "hall", "speed": 0.5}
    assert found.lost == ()


def test_subtree_of_version_3_gets_its_ports_by_remap(tmp_path: Path) -> None:
    """The names inside and outside, through two trees."""
    path, remap = tmp_path / "t.xml", '<remap internal="{}" external="{}"/>'
    inner = f'<SubTree ID="q">{remap.format("at", "to")}</SubTree>'
    parts = (
        f'<BehaviorTree ID="p">{inner}</BehaviorTree><BehaviorTree ID="q"><Go place="{{at}}"/></BehaviorTree>'
    )
    body = f'<SubTree ID="p">{remap.format("to", "hall")}</SubTree>'
    path.write_text(tree(body).replace("</root>", f"{parts}</root>"))
    found = import_file(path)
    assert found.data["actions"][0]["with"] == {"place": "{hall}"}
    assert ["{hall} stays as text" in lost.meaning for lost in found.lost] == [True]


def test_two_trees_of_one_name_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "t.xml"
    path.write_text(tree("<A/>").replace("</root>", '<BehaviorTree ID="p"/>\n<BehaviorTree ID="p"/></root>'))
    with pytest.raises(
        FileError, match=r"t\.xml:2:1: a second tree 'p', the first is in line 1; allowed: one"
    ):
        import_file(path)


def test_stand_ins_of_trees_and_machines_name_all_that_is_lost(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], read: Import
) -> None:
    trees, machines = tree_files(), machine_files()
    assert (len(trees), len(machines)) == (16, 19)
    assert imported("trees", written(trees, tmp_path / "trees"), lost_in_tree)
    assert imported("machines", written(machines, tmp_path / "machines"), lost_in_machine)
    assert "named 0 of 0" not in capsys.readouterr().out
    for name in ("recover.xml", "subtrees.xml", "scripted.xml"):
        assert read(name, trees[name]).network.actions


def test_machines_keep_outcomes_and_containers(read: Import) -> None:
    files = machine_files()
    network = read("outcomes.yaml", files["outcomes.yaml"]).network
    (ask,) = network.actions
    assert [(each.target, each.result) for each in ask.others] == [("done", "coffee")]
    assert leaves(read("nested.yaml", files["nested.yaml"]).network) == (["SERVE/POUR"], "done")
    found = leaves(read("plain.yaml", files["plain.yaml"]).network, {"GRASP": "F"})
    assert found == (["LOOK", "GRASP", "LOOK", "GRASP", "BRING"], "done")


def test_py_trees_in_memory_are_read() -> None:
    class Grasp(py_trees.behaviour.Behaviour):
        """A leaf."""

        def update(self) -> py_trees.common.Status:
            return py_trees.common.Status.SUCCESS

    root = py_trees.composites.Sequence("serve", memory=True)
    grasp = py_trees.decorators.Retry("again", Grasp("grasp"), 2)
    other = py_trees.composites.Selector("either", memory=False, children=[Grasp("left"), Grasp("right")])
    root.add_children([grasp, other, py_trees.decorators.RunningIsFailure("odd", Grasp("last"))])
    found = import_py_tree(root)
    assert [row["from"] for row in found.data["actions"]] == ["grasp 2", "grasp", "left", "right", "last"]
    assert found.data["start"] == "grasp 2"
    assert {each.construct for each in found.lost} == {"Selector 'either'", "RunningIsFailure 'odd'"}


@pytest.mark.parametrize("name", TASKS)
def test_exporting_and_importing_a_shipped_task_is_the_identity(tmp_path: Path, name: str) -> None:
    task = load_task(TASKS[name])
    parts = TaskParts.of_task(task)
    for kind, (_, suffix) in FORMAT_WRITERS.items():
        path = tmp_path / f"task{suffix}"
        path.write_text(exported(task, kind)[0], encoding="utf-8")
        assert import_file(path) == (parts.data(), ()), kind
    assert parts_of_py_tree(py_tree(parts, lambda _name, _given: (True, ""))).data() == parts.data()


def test_identity_reads_the_tree_and_not_a_copy_of_the_file() -> None:
    parts = TaskParts.of_task(load_task(TASKS["return_book"]))
    text = tree_text(parts).replace("situation := 'book_known'", "situation := 'at_shelf'")
    text = text.replace("<RECOGNIZE ", '<RECOGNIZE wait_s="3" ', 1)
    changed = parts_of_tree(parse_xml_tree(text.encode(), "t")).actions
    recognize = next(row for row in changed if row["do"] == "RECOGNIZE")
    assert (recognize["to"], recognize["with"]["wait_s"]) == ("at_shelf", 3)


def test_generated_networks_are_exported_as_written_ones(tmp_path: Path) -> None:
    folder = TASKS["return_book"].parent
    task = load_task(folder / "conditions.yaml")
    data: dict[str, Any] = TaskParts.of_task(task).data()
    assert len(data["actions"]) == len(task.network.actions)
    path = folder / "task.yaml"
    (tmp_path / "t.xml").write_text(exported(task, "bt")[0])
    back = import_file(tmp_path / "t.xml").data
    for key in ("world", "knowledge"):
        back.pop(key)
    back["parameters"].pop("world", None)
    assert [row["from"] for row in back["actions"]] == [each.source for each in task.network.actions]
    assert path.exists()


def test_py_trees_and_coordinator_agree_where_there_is_no_choice() -> None:
    parts = TaskParts.of_task(load_task(TASKS["calibrate_camera"]))
    done: list[str] = []

    def carry(name: str, _given: Mapping[str, Any]) -> tuple[bool, str]:
        done.append(name)
        return len(done) != 1, "blocked"

    tree_ = py_tree(parts, carry)
    while tree_.status in (py_trees.common.Status.INVALID, py_trees.common.Status.RUNNING):
        tree_.tick_once()
    assert tree_.status is py_trees.common.Status.SUCCESS
    assert done == [parts.actions[0]["do"], *(row["do"] for row in parts.actions)]


def test_hostile_files_end_in_words(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert hostile(60, 7, tmp_path / "files")
    assert "tracebacks 0" in capsys.readouterr().out


@pytest.mark.parametrize("name", ["bomb.xml", "external.xml", "deep.xml", "anchors.yaml", "tagged.yaml"])
def test_attacks_are_refused_with_their_place(tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_text(ATTACK_FILES[name])
    with pytest.raises(FileError) as error:
        import_file(tmp_path / name)
    assert error.value.findings[0].line >= 1


def test_retries_that_multiply_are_refused(tmp_path: Path) -> None:
    (tmp_path / "t.xml").write_text(ATTACK_FILES["retries.xml"])
    with pytest.raises(TooLargeDraft) as error:
        import_file(tmp_path / "t.xml")
    assert "more than 5000 actions; allowed: fewer" in str(error.value)


def test_models_of_others_are_read_where_they_are_plain(tmp_path: Path, read: Import) -> None:
    edges = [
        {"location": "a", "action": "go", "destinations": [{"location": "b", "probability": {"exp": 0.9}},
                                                            {"location": "a", "probability": {"exp": 0.1}}]},
        {"location": "b", "guard": {"exp": "x"}, "destinations": [{"location": "c"}]},
    ]  # fmt: skip
    places = [{"name": each} for each in "abc"]
    automaton = {"name": "m", "locations": places, "edges": edges, "initial-locations": ["a"]}
    model = {"jani-version": 1, "name": "m", "type": "mdp", "automata": [automaton]}
    (tmp_path / "m.jani").write_text(json.dumps(model))
    found = import_file(tmp_path / "m.jani")
    assert found.data["goal"] == "c"
    assert [each["p"] for each in found.data["actions"][0]["then"]] == [0.9, 0.1]
    assert any("guard of edge 1" in each.construct for each in found.lost)
    assert read("m.jani", json.dumps(model)).network.goal == "c"


def test_models_with_give_ups_have_probabilities_that_sum_to_1(tmp_path: Path) -> None:
    parts = TaskParts.of_task(load_task(TASKS["track_seam"]))
    assert any(row.get("p_give_up") for row in parts.actions)
    parts = TaskParts(parts.head, {**parts.situations, GAVE_UP_NAME: {}}, parts.actions, parts.order)
    (tmp_path / "m.jani").write_text(model_text(parts))
    automaton = json.loads((tmp_path / "m.jani").read_text())["automata"][0]
    names = [location["name"] for location in automaton["locations"]]
    assert len(set(names)) == len(names) == len(parts.situations) + 1
    for edge in automaton["edges"]:
        chances = [end["probability"]["exp"] for end in edge["destinations"]]
        assert sum(chances) == pytest.approx(1.0, abs=1e-12)
        assert {end["location"] for end in edge["destinations"]} <= set(names)
    ends = [
        (end["location"], end["probability"]["exp"]) for e in automaton["edges"] for end in e["destinations"]
    ]
    stated = [row["p_give_up"] for row in parts.actions if row.get("p_give_up")]
    assert [p for name, p in ends if name == names[-1]] == stated
    assert import_file(tmp_path / "m.jani").data == parts.data()


def test_choices_in_scripts_have_the_brackets_that_they_need() -> None:
    text = tree_text(TaskParts.of_task(load_task(TASKS["return_book"])))
    assert "' : ((cause == " in text
    assert "' : (cause == " not in text


@pytest.mark.parametrize("name", ["return_book", "drive_map", "track_seam"])
def test_exported_trees_run_in_behavior_tree_cpp_alike(name: str) -> None:
    """The real library and the tree of py_trees start the same leaves, whatever fails."""
    library = pytest.importorskip("behaviortreepy", reason="BehaviorTree.CPP itself is not installed")
    parts = TaskParts.of_task(load_task(TASKS[name]))
    leaf_names = {row["do"] for row in parts.actions}
    text = re.sub(r"<TreeNodesModel>.*</TreeNodesModel>", "", tree_text(parts), flags=re.S)
    for each in leaf_names:  # its simple actions have no ports
        text = re.sub(rf"<{each} [^>]*/>", f"<{each}/>", text)
    for seed in range(5):
        draws, real, ours = random.Random(seed), list[str](), list[str]()
        factory = library.BehaviorTreeFactory()

        def tick(name: str, real: list[str] = real, draws: random.Random = draws) -> Any:
            real.append(name)
            return library.NodeStatus.SUCCESS if draws.random() < 0.8 else library.NodeStatus.FAILURE

        for each in leaf_names:
            factory.register_simple_action(each, lambda _node=None, each=each, tick=tick: tick(each))
        status = factory.create_tree_from_text(text).tick_while_running()
        again = random.Random(seed)

        def carry(
            name: str, _given: Mapping[str, Any], ours: list[str] = ours, again: random.Random = again
        ) -> tuple[bool, str]:
            ours.append(name)
            return again.random() < 0.8, ""

        mine = py_tree(parts, carry)
        while mine.status in (py_trees.common.Status.INVALID, py_trees.common.Status.RUNNING):
            mine.tick_once()
        assert real == ours
        assert str(status).rpartition(".")[2] == mine.status.name


def test_damage_is_drawn_from_a_seed() -> None:
    from benchmarks.deciding.interchange import damaged

    assert damaged("abcdef" * 9, random.Random(3)) == damaged("abcdef" * 9, random.Random(3))


@pytest.mark.parametrize(
    ("body", "construct"),
    [
        ('<SubTree ID="p" __autoremap="true"/>', "__autoremap of <SubTree>"),  # BehaviorTree.CPP 563
        ("<RoundRobin><A/><B/></RoundRobin>", "<RoundRobin>"),  # navigation2 5033
        ('<SubTree ID="nowhere"/>', "<SubTree>"),  # BehaviorTree.CPP 259
        ('<A goal="{x}"/>', 'goal="{x}"'),  # navigation2 4004
    ],
)
def test_peers_reports_of_trees_are_named(tmp_path: Path, body: str, construct: str) -> None:
    part = '<BehaviorTree ID="p"><B/></BehaviorTree>'
    text = tree(body).replace("</root>", f"{part}</root>")
    (tmp_path / "t.xml").write_text(text)
    assert [each.construct for each in import_file(tmp_path / "t.xml").lost] == [construct]


def test_includes_without_a_path_are_named(tmp_path: Path) -> None:  # BehaviorTree.CPP 1003
    (tmp_path / "t.xml").write_text(tree("<A/>").replace("<BehaviorTree", "<include/><BehaviorTree", 1))
    assert [each.construct for each in import_file(tmp_path / "t.xml").lost] == ["<include>"]


@pytest.mark.parametrize("attempts", ["-1", "10"])
def test_retries_of_what_always_fails_never_succeed(read: Import, attempts: str) -> None:  # BT.CPP 888
    body = f'<RetryUntilSuccessful num_attempts="{attempts}"><AlwaysFailure/></RetryUntilSuccessful>'
    with pytest.raises(FileError) as error:
        read("t.xml", tree(body))
    assert "to done; allowed: a goal that can be reached" in str(error.value)


def test_conditions_that_are_retried_for_ever_end(read: Import) -> None:  # BehaviorTree.CPP 395
    body = '<RetryUntilSuccessful num_attempts="-1"><IsThere/></RetryUntilSuccessful>'
    found, situation = leaves(read("t.xml", tree(body)).network, {"IsThere": "F" * 10_000})
    assert 20 < len(found) < 10_000
    assert situation == "IsThere"


def test_main_tree_that_is_not_named_is_reported(tmp_path: Path) -> None:  # BehaviorTree.CPP 384
    part = '<BehaviorTree ID="other"><B/></BehaviorTree>'
    (tmp_path / "t.xml").write_text(
        tree("<A/>").replace(' main_tree_to_execute="t"', "").replace("</root>", f"{part}</root>")
    )
    (lost,) = import_file(tmp_path / "t.xml").lost
    assert "main_tree_to_execute is missing; it begins with 't'" in lost.meaning


def test_states_called_like_an_outcome_are_reported(tmp_path: Path) -> None:  # yasmin 40
    states = "states:\n  succeeded:\n    type: Say\n    transitions: {succeeded: succeeded}\n"
    text = f"outcomes: [succeeded]\n{states}"
    (tmp_path / "m.yaml").write_text(text)
    assert "state 'succeeded'" in {each.construct for each in import_file(tmp_path / "m.yaml").lost}
