"""A repeated part within a repeated part, and facts that follow from the element."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import pytest

from handcart.files.errors import FileError
from handcart.networks.coordination.coordinator import Coordinator
from handcart.networks.graph.network import Action
from handcart.networks.task.task_file import Task
from tests.networks.conftest import Stand

TRIPS = """\
format: handcart-task/1
title: Carry
robot: librarian
start: here
goal: done
situations:
  here: {load: 0}
  loading: {load: {each: item.before}}
  held: {load: {each: item.before}, hand: full}
  loaded: {load: 2}
  there: {load: {each: item.left}}
  done: {load: 0}
actions:
  - {do: THINK, from: here, to: loading, cost_s: 1, with: {name: a, text: {each: trip.place}}}
  - {do: THINK, from: loading, to: held, cost_s: 1, with: {name: b, text: {each: item.name}}}
  - {do: THINK, from: held, to: loaded, cost_s: 1, with: {name: c, text: {each: trip.place}}}
  - {do: THINK, from: loaded, to: there, cost_s: 1, with: {name: d}}
  - {do: THINK, from: there, to: done, cost_s: 1, with: {name: e, text: {each: item.name}}}
repeat:
  - {over: {parameter: trips}, as: trip, start: here, goal: done}
  - {over: {each: trip.items}, as: item, start: loading, goal: loaded}
  - {over: {each: trip.items}, as: item, start: there, goal: done}
parameters:
  trips:
    - {place: east, items: [{name: p, before: 0, left: 2}, {name: q, before: 1, left: 1}]}
    - {place: west, items: [{name: r, before: 0, left: 2}, {name: s, before: 1, left: 1}]}
"""

GOES_OVER = "{each: trip.items}, as: item, start: l"
ENDS = "start: loading, goal: loaded"


def fixed(action: Action) -> Mapping[str, Any]:
    assert action.binding is not None
    return action.binding.fixed


def test_each_trip_has_items_of_its_own(load: Callable[..., Task]) -> None:
    network = load(TRIPS).network
    ways = {(a.source, a.target): fixed(a).get("text", "") for a in network.actions}
    assert ways == {
        ("here[1]", "loading[1][1]"): "east",
        ("loading[1][1]", "held[1][1]"): "p",
        ("held[1][1]", "loading[1][2]"): "east",
        ("loading[1][2]", "held[1][2]"): "q",
        ("held[1][2]", "loaded[1]"): "east",
        ("loaded[1]", "there[1][1]"): "",
        ("there[1][1]", "there[1][2]"): "p",
        ("there[1][2]", "here[2]"): "q",
        ("here[2]", "loading[2][1]"): "west",
        ("loading[2][1]", "held[2][1]"): "r",
        ("held[2][1]", "loading[2][2]"): "west",
        ("loading[2][2]", "held[2][2]"): "s",
        ("held[2][2]", "loaded[2]"): "west",
        ("loaded[2]", "there[2][1]"): "",
        ("there[2][1]", "there[2][2]"): "r",
        ("there[2][2]", "done"): "s",
    }
    facts = {name: dict(situation.facts) for name, situation in network.situations.items()}
    assert facts["held[2][2]"] == {"load": 1, "hand": "full"}
    assert [facts[f"there[1][{n}]"]["load"] for n in (1, 2)] == [2, 1]
    words = {situation.element for situation in network.situations.values()}
    assert {"trip[1]", "trip[2], item[1] from loading", "trip[2], item[2] from there", None} <= words


def test_the_order_of_the_parts_does_not_matter(load: Callable[..., Task]) -> None:
    lines = TRIPS.splitlines()
    first = lines.index("repeat:") + 1
    lines[first : first + 3] = reversed(lines[first : first + 3])
    turned = load("\n".join(lines))
    assert {str(a) for a in turned.network.actions} == {str(a) for a in load(TRIPS).network.actions}


def test_knowledge_is_cleared_when_an_outer_element_ends(load: Callable[..., Task], stand: Stand) -> None:
    network, cleared = load(TRIPS).network, []
    coordinator = Coordinator(network, stand.robot, stand.model)
    model: Any = stand.model
    model.clear_element = lambda: cleared.append(coordinator.situation)
    end = stand.finish(coordinator)
    assert (end.outcome, end.actions) == ("Success", 16)
    assert cleared == [
        *("loading[1][2]", "loaded[1]", "there[1][2]", "here[2]"),
        *("loading[2][2]", "loaded[2]", "there[2][2]", "done"),
    ]


@pytest.mark.parametrize(
    ("old", "new", "line", "message"),
    [
        (GOES_OVER, "{each: trip.thing}, as: item, start: l", 21, "trip.thing"),
        (GOES_OVER, "{each: trap.items}, as: item, start: l", 21, "allowed: trip,"),
        (
            GOES_OVER,
            "{each: trip}, as: item, start: l",
            21,
            " ... of trip[1]; allowed: a list",
        ),
        (GOES_OVER, "{each: trip.place}, as: item, start: l", 21, "is 'east' of trip[1]"),
        (
            "load: {each: item.before}}",
            "load: {each: item.befor}}",
            8,
            "'item.befor'; did you mean 'item.before'?",
        ),
        ("loaded: {load: 2}", "loaded: {load: {each: item.before}}", 10, "unknown element 'item.before'"),
        ("here: {load: 0}", "here: {load: {each: trip.items}}", 7, "allowed for a fact: a word"),
        (ENDS, f"{ENDS}, unfinished: skip", 21, "load is another"),
    ],
)
def test_what_is_wrong_is_told_at_its_line(
    load: Callable[..., Task], old: str, new: str, line: int, message: str
) -> None:
    assert old in TRIPS
    with pytest.raises(FileError) as error:
        load(TRIPS.replace(old, new, 1))
    assert any(finding.line == line and message in finding.message for finding in error.value.findings), (
        error.value
    )


def test_parts_within_parts_are_no_bomb(load: Callable[..., Task]) -> None:
    """T3, T4: four lists of a hundred entries would make a hundred million copies."""
    hundred = list(range(100))
    parts = "".join(
        f"  - {{over: {hundred}, as: n{depth}, start: s{depth}, goal: z}}\n" for depth in range(4)
    )
    actions = "".join(
        f"  - {{do: THINK, from: s{depth}, to: {f's{depth + 1}' if depth < 3 else 'z'}, cost_s: 1}}\n"
        for depth in range(4)
    )
    head = "format: handcart-task/1\ntitle: Bomb\nrobot: librarian\nstart: s0\ngoal: z\n"
    situations = "situations: {s0: {}, s1: {}, s2: {}, s3: {}, z: {}}\n"
    with pytest.raises(FileError, match=r"with it the network has 2010100 actions; allowed: at most 200000"):
        load(f"{head}{situations}actions:\n{actions}repeat:\n{parts}")
