from __future__ import annotations

from itertools import combinations, pairwise
from pathlib import Path

import pytest

from handcart.evaluation.report.network_picture import LETTER, Box, NetworkPicture, draw_network, folded
from handcart.networks.graph.journaled_network import NamedBinding
from handcart.networks.graph.network import Action, ActionNetwork, Situation
from handcart.networks.journal.past_run import PastAction
from handcart.networks.task.task_file import load_task

TASKS = sorted((Path(__file__).parents[3] / "tasks").glob("*/task.yaml"))


def apart(a: Box, b: Box) -> bool:
    beside = a.x + a.width <= b.x or b.x + b.width <= a.x
    return beside or a.y + a.height <= b.y or b.y + b.height <= a.y


def holds(picture: NetworkPicture, box: Box) -> bool:
    within = box.x >= 0 and box.y >= 0
    return within and box.x + box.width <= picture.width and box.y + box.height <= picture.height


@pytest.mark.parametrize("task", TASKS, ids=lambda path: path.parent.name)
def test_nothing_overlaps_and_nothing_is_clipped(task: Path) -> None:
    picture = draw_network(load_task(task).network, ())
    assert all(apart(a, b) for a, b in combinations(picture.boxes, 2))
    assert all(holds(picture, box) for box in picture.boxes)
    assert all(LETTER * max(len(box.words), len(box.below)) <= box.width for box in picture.boxes)


def an_action(number: int, do: str, source: str, target: str, outcome: str) -> PastAction:
    return PastAction(number, 0, do, source, target, {}, 0.0, 1.0, None, outcome)


def test_copies_of_a_repeat_are_one_box_that_counts_them_all() -> None:
    names = ("here", "there[1]", "there[2]", "done")
    network = ActionNetwork.build(
        [Situation(name, {}) for name in names],
        [Action(a, b, NamedBinding(name="GO")) for a, b in pairwise(names)],
        "here",
        "done",
    )
    ran = [
        an_action(1, "GO", "there[1]", "there[2]", "Fail"),
        an_action(2, "GO", "there[1]", "there[2]", "Success"),
    ]
    boxes = draw_network(network, ran).boxes
    assert sorted(box.words for box in boxes if box.kind == "situation") == ["done", "here", "there"]
    assert [box.below for box in boxes if box.kind == "mixed"] == ["1 Success, 1 Fail"]
    assert {box.kind for box in boxes} == {"situation", "mixed", "untried"}


def test_a_fail_has_not_come_to_the_target() -> None:
    network = ActionNetwork.build(
        [Situation("here", {}), Situation("there", {})],
        [Action("here", "there", NamedBinding(name="GO"))],
        "here",
        "there",
    )
    failed = draw_network(network, [an_action(1, "GO", "here", "there", "Fail")])
    assert [link.travelled for link in failed.links] == [True, False]
    went = draw_network(network, [an_action(1, "GO", "here", "there", "Success")])
    assert [link.travelled for link in went.links] == [True, True]


def test_only_the_number_of_an_element_is_folded() -> None:
    assert folded("taken[1][12]") == "taken"
    assert folded("at_shelf_2") == "at_shelf_2"
