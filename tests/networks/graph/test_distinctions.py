"""Equal actions between the same situations are named differently in every message."""

from __future__ import annotations

from handcart.networks.graph.network import Action, ActionNetwork, Binding, Situation
from handcart.primitives.driving.move_to import MoveTo


def titles(*actions: Action) -> list[str]:
    situations = [Situation("home"), Situation("shelf")]
    return [str(action) for action in ActionNetwork.build(situations, actions, "home", "shelf").actions]


def drive(cost_s: float = 1.0, reverse: bool = False) -> Action:
    return Action("home", "shelf", Binding.of(MoveTo(place="shelf", reverse=reverse)), cost_s)


def test_a_lone_action_keeps_its_short_title() -> None:
    assert titles(drive(reverse=True)) == ["MOVE_TO (home to shelf)"]


def test_parallel_actions_show_the_parameters_that_differ() -> None:
    first, second = titles(drive(), drive(2.0, reverse=True))
    assert first == "MOVE_TO (home to shelf)"
    assert second == "MOVE_TO with reverse: true (home to shelf)"


def test_parallel_actions_that_differ_in_cost_alone_show_it() -> None:
    assert titles(drive(1.0), drive(2.5)) == [
        "MOVE_TO with cost_s: 1 (home to shelf)",
        "MOVE_TO with cost_s: 2.5 (home to shelf)",
    ]


def test_actions_with_other_targets_are_not_alike() -> None:
    back = Action("shelf", "home", drive().binding)
    assert titles(drive(), back) == ["MOVE_TO (home to shelf)", "MOVE_TO (shelf to home)"]
