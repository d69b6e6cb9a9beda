"""Several repeated parts in one task: each action gets the elements of its own part, and no others."""

import re
from collections import deque
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pytest

from handcart.files.errors import FileError
from handcart.files.models.json_schema import schema
from handcart.networks.analysis.figures import figures
from handcart.networks.analysis.task_findings import task_findings
from handcart.networks.coordination.coordinator import Coordinator
from handcart.networks.coordination.script import follow
from handcart.networks.drawing.drawing import WRITER_BY_SUFFIX
from handcart.networks.events.events import Event, Started
from handcart.networks.graph.network import Action
from handcart.networks.task.preparing import beginning_at
from handcart.networks.task.task_file import Task
from handcart.networks.task.task_model import TaskFile
from tests.networks.conftest import Stand

TWICE = """\
format: handcart-task/1
title: Think twice
robot: librarian
start: s
goal: z
situations:
  s:
  a: {book: here}
  b: {book: there}
  c: {book: there}
  d: {book: away}
  z:
actions:
  - {do: THINK, from: s, to: a, cost_s: 1, with: {name: s}}
  - {do: THINK, from: a, to: b, cost_s: 1, with: {name: x, text: {each: word}}}
  - {do: THINK, from: b, to: c, cost_s: 1, with: {name: y}}
  - {do: THINK, from: c, to: d, cost_s: 1, with: {name: u, text: {each: word}}}
  - {do: THINK, from: d, to: z, cost_s: 1, with: {name: v}}
repeat:
  - {over: [one, two], as: word, start: a, goal: c, unfinished: skip}
  - {over: [three, four, five], as: word, start: c, goal: z, unfinished: skip}
"""


def fixed(action: Action) -> Mapping[str, Any]:
    assert action.binding is not None
    return action.binding.fixed


def changed(old: str, new: str, text: str = TWICE) -> str:
    assert old in text
    return text.replace(old, new)


def test_two_parts_one_after_the_other(load: Callable[..., Task]) -> None:
    network = load(TWICE).network
    assert list(network.situations) == [
        "s", "a[1]", "a[2]", "b[1]", "b[2]", "c[1]", "c[2]", "c[3]", "d[1]", "d[2]", "d[3]", "z",
    ]  # fmt: skip
    done = [a for a in network.actions if a.binding]
    assert [str(a) for a in done] == [
        "THINK (s to a[1])",
        "THINK (a[1] to b[1])",
        "THINK (a[2] to b[2])",
        "THINK (b[1] to a[2])",
        "THINK (b[2] to c[1])",
        "THINK (c[1] to d[1])",
        "THINK (c[2] to d[2])",
        "THINK (c[3] to d[3])",
        "THINK (d[1] to c[2])",
        "THINK (d[2] to c[3])",
        "THINK (d[3] to z)",
    ]
    texts = [fixed(a)["text"] for a in done if fixed(a).get("text")]
    assert texts == ["one", "two", "three", "four", "five"]
    skips = [str(a) for a in network.actions if not a.binding]
    assert skips == [
        f"SKIP ({way})"
        for way in ("a[1] to a[2]", "a[2] to c[1]", "c[1] to c[2]", "c[2] to c[3]", "c[3] to z")
    ]
    attempts = 11 * 3 + 5
    assert network.bound() == (attempts + 1) * 11 + attempts


def test_the_order_in_the_list_does_not_matter(load: Callable[..., Task]) -> None:
    first, second = TWICE.splitlines()[-2:]
    turned = load(changed(f"{first}\n{second}", f"{second}\n{first}")).network
    assert {str(a) for a in turned.actions} == {str(a) for a in load(TWICE).network.actions}


def test_one_mapping_is_a_list_of_one(load: Callable[..., Task]) -> None:
    text = TWICE[: TWICE.index("  - {over: [three")].replace("{name: u, text: {each: word}}", "{name: u}")
    one = changed("repeat:\n  - {over", "repeat: {over", text)
    assert load(one).network.fingerprint() == load(text).network.fingerprint()


def test_both_parts_skip_and_say_which(load: Callable[..., Task], stand: Stand) -> None:
    stand.script |= {"x": deque("SP"), "u": deque("PSS")}
    network, cleared = load(TWICE).network, []
    coordinator = Coordinator(network, stand.robot, stand.model)
    model: Any = stand.model
    model.clear_element = lambda: cleared.append(coordinator.situation)
    end = stand.finish(coordinator)
    assert (end.outcome, end.exit_status, end.situation) == ("Fail", 3, "z")
    assert end.skipped == ("word[2] (two) from a", "word[1] (three) from c")
    assert cleared == ["a[2]", "c[1]", "c[2]", "c[3]", "z"]


def test_imagined_run_ends_as_one_that_skipped_an_element(load: Callable[..., Task]) -> None:
    imagined = follow(load(TWICE).network, ["Success", "Success", "Success", "FailForGood"])
    assert (imagined.outcome, imagined.situation) == ("Fail", "z")
    assert imagined.reason == "left undone: word[2] (two) from a"
    assert imagined.lines[4] == "5. SKIP (a[2] to c[1]): word[2] (two) from a is left undone"
    summary = imagined.summary()
    assert (summary["actions"], len(summary["did"])) == (10, 11)
    assert summary["skipped"] == ["word[2] (two) from a"]


def test_element_knowledge_is_cleared_between_two_parts(load: Callable[..., Task], stand: Stand) -> None:
    network, cleared = (
        load(changed("[three, four, five]", "[one]", changed("[one, two]", "[one]"))).network,
        [],
    )
    coordinator = Coordinator(network, stand.robot, stand.model)
    model: Any = stand.model
    model.clear_element = lambda: cleared.append(coordinator.situation)
    stand.finish(coordinator)
    assert cleared == ["c[1]", "z"]


def test_a_run_may_begin_in_the_second_part(load: Callable[..., Task], stand: Stand) -> None:
    network = beginning_at(load(TWICE).network, "c[3]")
    events: list[Event] = []
    end = stand.finish(Coordinator(network, stand.robot, stand.model, observers=[events.append]))
    begun: list[Any] = [event.primitive for event in events if isinstance(event, Started)]
    texts = [primitive.text for primitive in begun]
    assert (end.outcome, texts) == ("Success", ["five", ""])


def test_elements_of_another_part_are_unknown(load: Callable[..., Task]) -> None:
    text = changed("as: word, start: c", "as: term, start: c")
    with pytest.raises(FileError) as error:
        load(text)
    (found,) = error.value.findings
    assert (found.line, found.column) == (17, 66)
    assert found.message == "unknown element 'word'; allowed: term, term.KEY with a key of each element"
    task = load(changed("name: u, text: {each: word}", "name: u, text: {each: term}", text))
    elements = {situation.element for situation in task.network.situations.values()}
    assert {"word[1] (one)", "term[1] (three)"} < elements


def test_a_wrong_list_is_reported_once(load: Callable[..., Task]) -> None:
    """The uses of its element are right."""
    with pytest.raises(FileError) as error:
        load(changed("over: [one, two]", "over: one,two"))
    assert {found.line for found in error.value.findings} == {20}


@pytest.mark.parametrize(
    ("old", "new", "line", "column", "message"),
    [
        ("start: c, goal: z", "start: b, goal: z", 21, 50, "the part shares 'b' with the one from a"),
        ("start: a, goal: c", "start: a, goal: d", 21, 50, "the part shares 'c' with the one from a"),
        ("from: b, to: c", "from: b, to: d", 21, 50, "the part shares 'd' with the one from a"),
        ("from: b, to: c", "from: b, to: d", 16, 30, "leads into the middle of the repeated part"),
        ("from: s, to: a", "from: s, to: d", 14, 30, "leads into the middle of the repeated part"),
        (
            "from: b, to: c",
            "from: b, to: c, on_fail: c",
            16,
            42,
            "leads to the next element's 'a', where other",
        ),
        ("start: c, goal: z", "start: c, goal: x", 21, 59, "unknown situation 'x'"),
        ("as: word, start: c", "start: c", 21, 5, "the key 'as' is missing"),
        ("as: word, start: c", "as: word, begin: 1, start: c", 21, 43, "unknown key 'begin'"),
        ("[three, four, five]", "[]", 21, 12, "over is a list of 0"),
        ("[three, four, five]", "[three, 4]", 21, 20, "text is 4"),
        ("goal: z\nsit", "goal: c\nsit", 5, 7, "is inside the repeated part"),
    ],
)
def test_what_is_wrong_with_one_of_the_parts(
    load: Callable[..., Task], old: str, new: str, line: int, column: int, message: str
) -> None:
    with pytest.raises(FileError) as error:
        load(changed(old, new))
    places = {(finding.line, finding.column): finding.message for finding in error.value.findings}
    assert message in places.get((line, column), ""), error.value


@pytest.mark.parametrize(
    ("value", "column", "message"),
    [("[]", 9, "repeat is"), ("7", 9, "repeat is 7; allowed: "), ("[7]", 10, "repeat[0] is 7; allowed: ")],
)
def test_a_repeat_of_another_kind(load: Callable[..., Task], value: str, column: int, message: str) -> None:
    text = TWICE[: TWICE.index("repeat:")].replace("{each: word}", "t")
    with pytest.raises(FileError, match=f"task.yaml:19:{column}: {re.escape(message)}"):
        load(f"{text}repeat: {value}\n")


def test_a_part_that_ends_where_it_begins(load: Callable[..., Task]) -> None:
    """An action that leads there from outside begins it; a Fail inside leads back to the element's own
    start.
    """
    text = changed(
        "start: c, goal: z", "start: c, goal: c", changed("from: d, to: z", "from: d, to: c, on_fail: c")
    )
    text = text.replace("goal: z\n", "goal: c\n").replace("  d: {book: away}", "  d: {book: there}")
    actions = load(text).network.actions
    ways = {str(a): a.on_fail for a in actions}
    assert "THINK (b[2] to c[1])" in ways
    assert ways["THINK (d[1] to c[2])"] == "c[1]"
    assert ways["THINK (d[3] to c)"] == "c[3]"


def test_fail_leading_to_a_parts_goal_leads_to_the_next_element(load: Callable[..., Task]) -> None:
    text = changed("from: b, to: c", "from: b, to: c, on_fail: c").replace("{book: here}", "{book: there}")
    assert [a.on_fail for a in load(text).network.actions if a.on_fail] == ["a[2]", "c[1]"]


def test_what_check_tells_is_of_both_parts(load: Callable[..., Task]) -> None:
    text = re.sub(" {book: .*", "", TWICE.replace("cost_s: 1,", "cost_s: 1, attempts: 1, p: 0.9,"))
    task = load(text)
    assert task_findings(task) == []
    end = figures(task).forecast
    assert end.goal == pytest.approx(0.9**11)
    # An element can be skipped from anywhere; only the way to the first one cannot.
    assert end.left_undone == pytest.approx(0.9 - 0.9**11)
    lost = "  - {do: THINK, from: d, to: e, cost_s: 9, p: 1, with: {name: e}}\nrepeat"
    found = task_findings(
        load(text.replace("repeat", lost, 1).replace("  z:\n", "  e: {book: lost}\n  z:\n"))
    )
    assert [finding.message.split(":")[0] for finding in found] == ["from 'e' nothing leads to the goal"]


def test_drawings_show_both_parts_once(load: Callable[..., Task]) -> None:
    network = load(TWICE).network
    for suffix in (".svg", ".mmd", ".dot"):
        picture = WRITER_BY_SUFFIX[suffix](network, "")
        assert "for each word, 2 times: one, two" in picture
        assert "for each word, 3 times: three, four, five" in picture
        assert "[2]" not in picture


def test_places_of_the_map_in_both_parts(load: Callable[..., Task], tmp_path: Path) -> None:
    (tmp_path / "lib").mkdir()
    places = "format: handcart-places/1\nplaces:\n  home: {x_m: 0, y_m: 0, heading_deg: 0}\n"
    (tmp_path / "lib" / "places.yaml").write_text(places)
    (tmp_path / "lib" / "map.yaml").write_text("")
    text = changed("start: s\ngoal", "knowledge: {map: map.yaml, places: places.yaml}\nstart: s\ngoal")
    text = text.replace("[one, two]", "{all: places}").replace("[three, four, five]", "{all: places}")
    elements = {situation.element for situation in load(text).network.situations.values()}
    assert elements == {None, "word[1] (home) from a", "word[1] (home) from c"}


def test_editors_know_both_forms() -> None:
    repeat = schema(TaskFile)["properties"]["repeat"]
    assert [item.get("type", item.get("$ref")) for item in repeat["anyOf"]] == [
        "array",
        "#/$defs/Repeat",
        "null",
    ]
    assert repeat["anyOf"][0]["items"] == {"$ref": "#/$defs/Repeat"}
