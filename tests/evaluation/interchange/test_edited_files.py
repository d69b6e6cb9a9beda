"""Exported tasks that were edited in a program of the other format, and read again."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest

from handcart.evaluation.interchange.bt_export import tree_text
from handcart.evaluation.interchange.importing import import_file
from handcart.evaluation.interchange.jani import model_text
from handcart.evaluation.interchange.scxml import chart_text
from handcart.evaluation.interchange.task_draft import TooLargeDraft
from handcart.evaluation.interchange.task_parts import TaskParts

WRITERS = {"xml": tree_text, "scxml": chart_text, "jani": model_text}
ACTION = {
    "do": "EXPLORE",
    "from": "here",
    "then": [{"to": "goal", "p": 0.6}, {"to": "left", "p": 0.2, "result": "part"}],
    "on_fail": {"blocked": {"to": "left", "p": 0.1}, "else": "right"},
    "with": {"name": "hall"},
}
PLACES = ("here", "left", "right", "goal")


def task(action: dict[str, Any]) -> TaskParts:
    head = {"format": "handcart-task/1", "title": "t", "start": "here", "goal": "goal"}
    return TaskParts.of_data({**head, "situations": {name: {} for name in PLACES}, "actions": [action]})


def read_again(folder: Path, kind: str, text: str) -> Any:
    """Return the only action of an edited file."""
    (folder / f"t.{kind}").write_text(text)
    (row,) = import_file(folder / f"t.{kind}").data["actions"]
    return row


def led_elsewhere(kind: str, text: str, old: str, new: str) -> str:
    """Return an exported file in which whatever leads to one situation leads to another."""
    if kind == "jani":
        model = json.loads(text)
        for edge in model["automata"][0]["edges"]:
            for end in edge["destinations"]:
                end["location"] = new if end["location"] == old else end["location"]
        return json.dumps(model)
    if kind == "scxml":
        ids = {name: f"s{place}" for place, name in enumerate(PLACES)}
        return text.replace(f'target="{ids[old]}"', f'target="{ids[new]}"')
    scripts = re.compile(r'(<Script code="[^"]*)"/>')
    return scripts.sub(lambda found: found[0].replace(f"'{old}'", f"'{new}'"), text)


@pytest.mark.parametrize("kind", WRITERS)
@pytest.mark.parametrize("action", [ACTION, {**ACTION, "on_fail": {"blocked": {"p": 0.1}}}])
def test_unchanged_files_are_read_as_they_were_written(
    tmp_path: Path, kind: str, action: dict[str, Any]
) -> None:
    assert read_again(tmp_path, kind, WRITERS[kind](task(action))) == action


@pytest.mark.parametrize("kind", WRITERS)
def test_each_way_of_an_action_can_be_led_elsewhere(tmp_path: Path, kind: str) -> None:
    text = led_elsewhere(kind, WRITERS[kind](task(ACTION)), "left", "right")
    assert read_again(tmp_path, kind, text) == {
        **ACTION,
        "then": [{"to": "goal", "p": 0.6}, {"to": "right", "p": 0.2, "result": "part"}],
        "on_fail": {"blocked": {"to": "right", "p": 0.1}, "else": "right"},
    }


@pytest.mark.parametrize("kind", WRITERS)
def test_a_fail_that_led_back_can_be_led_elsewhere(tmp_path: Path, kind: str) -> None:
    row = {"do": "LOOK", "from": "here", "to": "goal", "p": 0.9}
    changed = led_elsewhere(kind, WRITERS[kind](task(row)), "here", "left")
    if kind == "xml":  # the first script begins in the situation
        changed = changed.replace("situation := 'left'; cause", "situation := 'here'; cause")
    assert read_again(tmp_path, kind, changed) == {**row, "on_fail": "left"}


def test_a_model_keeps_the_situation_after_an_impossible_success(tmp_path: Path) -> None:
    row = {"do": "LOOK", "from": "here", "to": "goal", "p": 0.0, "on_fail": "left"}
    assert read_again(tmp_path, "jani", model_text(task(row))) == row


def test_a_model_with_another_number_of_ends_is_refused(tmp_path: Path) -> None:
    model = json.loads(model_text(task(ACTION)))
    model["automata"][0]["edges"][0]["destinations"].pop()
    with pytest.raises(Exception, match="3 destinations of EXPLORE; allowed: as many as exported"):
        read_again(tmp_path, "jani", json.dumps(model))


def test_names_that_an_editor_gives_to_leaves_are_no_parameters(tmp_path: Path) -> None:
    """As of Groot, which also writes `Action` with an ID; a parameter `name` is kept."""
    row = {"do": "LOOK", "from": "here", "to": "goal", "with": {"wait_s": 3}}
    text = tree_text(task(row)).replace("<LOOK ", '<Action ID="LOOK" name="LOOK" _uid="7" ')
    assert read_again(tmp_path, "xml", text) == row
    assert read_again(tmp_path, "xml", tree_text(task(ACTION))) == ACTION


@pytest.mark.parametrize("tag", ['RetryUntilSuccessful num_attempts="100"', 'Repeat num_cycles="100"'])
def test_nested_retries_of_nothing_are_refused(tmp_path: Path, tag: str) -> None:
    body = f"<{tag}>" * 5 + "<AlwaysFailure/>" + f"</{tag.split()[0]}>" * 5
    (tmp_path / "t.xml").write_text(f'<root><BehaviorTree ID="t">{body}</BehaviorTree></root>')
    with pytest.raises(TooLargeDraft):
        import_file(tmp_path / "t.xml")
