"""Actions that what the hand holds never lets start are found before anything moves."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from handcart.networks.analysis.hand_facts import hand_by_facts
from handcart.networks.analysis.hand_findings import denied_hand_facts, hand_findings
from handcart.networks.task.task_file import load_task
from handcart.primitives.preconditions.hand_use import Hand
from handcart.tools.checks.check_task import task_facts

STACKING = Path(__file__).resolve().parents[3] / "tasks" / "stack_blocks"
HEAD = """\
format: handcart-task/1
title: Two blocks
robot: toyama
world: unload_world.yaml
knowledge: {map: map.yaml, places: places.yaml, building: building.yaml}
start: a
goal: d
situations: {a: SITUATION, b: {hand: FACT}, c: {}, d: {}}
actions:
"""
LINE = "  - {{do: {}, from: {}, to: {}, cost_s: 1, with: {{number: {}, {}}}}}\n"


def found(folder: Path, *actions: str, start: str = "{}", fact: str = "holds a block") -> list[str]:
    """Findings of a task with these actions, without the folder."""
    path = shutil.copytree(STACKING, folder / "stacking", dirs_exist_ok=True) / "task.yaml"
    path.write_text(HEAD.replace("SITUATION", start).replace("FACT", fact) + "".join(actions))
    task = load_task(path)
    return [
        str(finding).removeprefix(f"{path}:") for finding in [*hand_findings(task), *denied_hand_facts(task)]
    ]


def take(way: str, number: int) -> str:
    return LINE.format("PICK_UP_BLOCK", *way, number, "at: robot")


def put(way: str, number: int) -> str:
    return LINE.format("STACK", *way, number, "onto: goal")


def test_a_second_block_can_not_be_taken(tmp_path: Path) -> None:
    assert found(tmp_path, take("ab", 1), take("bc", 2), put("cd", 2)) == [
        "11:31: PICK_UP_BLOCK can't start in 'b': it needs an empty hand, and the hand holds block 1 "
        "(after PICK_UP_BLOCK, line 10); allowed: an action before it that sees to that"
    ]


def test_another_block_than_the_held_one_can_not_be_put_down(tmp_path: Path) -> None:
    (one,) = found(tmp_path, take("ab", 1), put("bd", 2))
    assert one.startswith("11:23: STACK can't start in 'b': it needs block 2 in the hand, and the hand holds")


def test_facts_alone_prove_that_an_action_can_not_start(tmp_path: Path) -> None:
    (one,) = found(tmp_path, put("ad", 1), start="{hand: empty}")
    assert "it needs block 1 in the hand, and the hand is empty (hand: empty)" in one


def test_facts_that_deny_an_effect_are_found(tmp_path: Path) -> None:
    (one,) = found(tmp_path, take("ab", 1), put("bd", 1), fact="empty")
    assert one.startswith(
        "10:38: PICK_UP_BLOCK leaves the hand with block 1 in it, but 'b' says 'hand: empty'"
    )


def test_a_sound_order_and_an_unknown_start_have_no_finding(tmp_path: Path) -> None:
    assert found(tmp_path, take("ab", 1), put("bc", 1), take("cd", 2)) == []
    assert found(tmp_path, put("ad", 1)) == []


def test_an_action_with_one_sound_way_to_it_has_no_finding(tmp_path: Path) -> None:
    assert (
        found(tmp_path, take("ab", 1), LINE.format("PICK_UP_BLOCK", "a", "b", 2, "at: robot"), put("bd", 2))
        == []
    )


def test_check_counts_it_as_a_fault(tmp_path: Path) -> None:
    found(tmp_path, take("ab", 1), take("bd", 2))
    assert len(task_facts(load_task(tmp_path / "stacking" / "task.yaml"))["errors"]) == 1


@pytest.mark.parametrize(
    ("facts", "hand"),
    [
        ({"hand": "empty"}, Hand.EMPTY),
        ({"gripper": "Holds a book"}, Hand.FULL),
        ({"hand": "holds nothing"}, Hand.EMPTY),
        ({"book": "in hand"}, Hand.FULL),
        ({"hand": "drawn back", "load": 3}, Hand.ANY),
    ],
)
def test_facts_say_what_the_hand_holds(facts: dict[str, str], hand: Hand) -> None:
    assert hand_by_facts(facts)[0] is hand
