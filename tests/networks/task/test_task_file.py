"""Task files: what is wrong in them, all at once with its place; and repeating (rows T10 to T12, T17)."""

import time
from collections import deque
from collections.abc import Callable, Mapping
from pathlib import Path
from types import SimpleNamespace
from typing import Any, ClassVar

import pytest

from handcart.backends.robot.robot import Robot
from handcart.files.errors import FileError
from handcart.networks.coordination.coordinator import Coordinator
from handcart.networks.events.events import Event, Started
from handcart.networks.graph.network import Action
from handcart.networks.task.task_file import Task, load_task
from handcart.primitives.contract.action_primitive import ActionPrimitive, Periods
from handcart.primitives.knowledge.place_name import PlaceName
from handcart.primitives.knowledge.world_model import ModelView
from tests.networks.conftest import Stand

TASK = """\
format: handcart-task/1
title: Think
robot: librarian
parameters: {word: hello, words: [one, two, three]}
start: a
goal: z
situations:
  a: {book: here}
  b: {book: there}
  z:
actions:
  - {do: THINK, from: a, to: b, cost_s: 2, with: {name: x, text: {parameter: word}}}
  - {do: THINK, from: b, to: z, cost_s: 1, with: {name: y}}
"""
REPEAT = """\
repeat:
  over: {parameter: words}
  as: word
  start: a
  goal: z
  unfinished: skip
"""


def fixed(action: Action) -> Mapping[str, Any]:
    assert action.binding is not None
    return action.binding.fixed


def findings(load: Callable[..., Task], text: str, **settings: str) -> list[tuple[int, str]]:
    with pytest.raises(FileError) as error:
        load(text, **settings)
    return [(finding.line, finding.message) for finding in error.value.findings]


class Dawdle(ActionPrimitive):
    """Waits by the wall clock."""

    def motion(self, robot: Robot, model: ModelView) -> Periods:
        end = time.monotonic() + 0.1
        while True:
            if time.monotonic() > end:
                return
            yield


def test_a_primitive_that_reads_the_wall_clock_is_a_finding(
    load: Callable[..., Task], primitives: SimpleNamespace
) -> None:
    primitives.DAWDLE = Dawdle
    found = findings(load, TASK.replace("do: THINK, from: a", "do: DAWDLE, from: a"))
    words = [message for line, message in found if line == 12 and "Dawdle reads the wall clock" in message]
    assert len(words) == 2
    assert "time.monotonic, test_task_file.py:" in words[0]
    assert "allowed: robot.time" in words[0]


def test_a_primitive_is_looked_up_once_for_all_its_actions(
    tmp_path: Path, primitives: SimpleNamespace
) -> None:
    """Each look-up searches the packages for plugins of the same name, too."""
    asked: list[str] = []

    def primitive(name: str) -> type[ActionPrimitive]:
        asked.append(name)
        if name != "THINK":
            raise KeyError(name)
        kind: type[ActionPrimitive] = primitives.THINK
        return kind

    path = tmp_path / "task.yaml"
    path.write_text(TASK)
    load_task(path, {}, primitive)
    assert asked == ["THINK"]
    path.write_text(TASK.replace("THINK", "THIMK"))
    with pytest.raises(FileError) as error:
        load_task(path, {}, primitive)
    assert [finding.line for finding in error.value.findings] == [12, 13]


def test_good_file(load: Callable[..., Task]) -> None:
    task = load(TASK)
    assert [str(action) for action in task.network.actions] == ["THINK (a to b)", "THINK (b to z)"]
    assert fixed(task.network.actions[0]) == {"name": "x", "text": "hello"}
    assert task.network.bound() == (6 + 1) * 2 + 6
    assert fixed(load(TASK, word="bye").network.actions[0])["text"] == "bye"
    assert load(TASK).network.fingerprint() == task.network.fingerprint()
    assert load(TASK, word="bye").network.fingerprint() != task.network.fingerprint()


def test_everything_at_once(load: Callable[..., Task]) -> None:
    """T10, T12: each with the nearest that is allowed."""
    text = (
        TASK.replace("goal: z", "goal: zz")
        .replace("do: THINK, from: a", "do: THINKS, from: a")
        .replace("from: b, to: z, cost_s: 1", "from: b, to: y, cost_s: 1, on_fail: a, atempts: 2")
        .replace("{name: y}", "{nam: 7}")
        .replace("{parameter: word}", "{parameter: wrd}")
    )
    found = findings(load, text)
    lines = "\n".join(f"{line} {message}" for line, message in found)
    for part in (
        "6 unknown situation 'zz'",
        "12 unknown primitive 'THINKS'",
        "12 unknown parameter 'wrd'; did you mean 'word'?",
        "13 unknown key 'atempts'; did you mean 'attempts'?",
    ):
        assert part in lines
    also = findings(load, text.replace(", atempts: 2", ""))
    lines = "\n".join(f"{line} {message}" for line, message in also)
    for part in (
        "13 unknown situation 'y'",
        "13 'a' has other physical facts than 'b'",
        "13 unknown key 'nam'; did you mean 'name'?",
    ):
        assert part in lines


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("cost_s: 2", "cost_s: 0", "cost_s is 0"),
        ("cost_s: 2", "cost_s: -1.5", "cost_s is -1.5"),
        ("cost_s: 2", "cost_s: fast", "cost_s is 'fast'"),
        ("cost_s: 2", "cost_s: 2, attempts: 0", "attempts is 0"),
        ("from: b, to: z", "from: b, to: a", "no actions lead from a to z"),
        ("name: y", "name: {model: book.sehlf}", "did you mean 'shelf'?"),
        ("name: y", "name: {model: book.accession}", "book.accession is of type int; allowed: str"),
        ("name: y", "name: {each: word}", "unknown element 'word'"),
        ("robot: librarian", "robot: librarian\nworld: none.yaml", "missing file 'none.yaml'"),
        ("robot: librarian", "robot: librarian\nworld: ../../w.yaml", "leads out of"),
        ("robot: librarian", "robot: librarian\nworld: /etc/passwd", "is absolute"),
    ],
)
def test_one_thing_wrong(load: Callable[..., Task], old: str, new: str, message: str) -> None:
    found = findings(load, TASK.replace(old, new))
    assert len(found) == 1
    assert message in found[0][1]
    assert found[0][0] > 0


def test_settings_are_checked_as_the_file(load: Callable[..., Task]) -> None:
    found = findings(load, TASK, word="7")
    assert found[0][0] == 0
    assert "text is 7" in found[0][1]


def test_places_are_known(load: Callable[..., Task], tmp_path: Path, primitives: SimpleNamespace) -> None:
    class Go(ActionPrimitive):
        place: PlaceName
        only_knowledge: ClassVar = True

        def motion(self, robot: Robot, model: ModelView) -> Periods:
            return
            yield

    primitives.GO = Go
    places = "format: handcart-places/1\nplaces:\n  home: {x_m: 0, y_m: 0, heading_deg: 0}\n"
    (tmp_path / "lib").mkdir()
    (tmp_path / "lib" / "places.yaml").write_text(places)
    (tmp_path / "lib" / "map.yaml").write_text("")
    text = TASK.replace("start: a", "knowledge: {map: map.yaml, places: places.yaml, start: hom}\nstart: a")
    text = text.replace("do: THINK, from: b", "do: GO, from: b").replace("{name: y}", "{place: hme}")
    found = findings(load, text)
    assert [line for line, _ in found] == [5, 14]
    assert all("unknown place" in message and "did you mean 'home'?" in message for _, message in found)


def test_missing_capabilities_are_listed(load: Callable[..., Task], stand: Stand) -> None:
    task = load(TASK.replace("do: THINK, from: b", "do: DRIVE, from: b").replace(", with: {name: y}", ""))
    task.check_capabilities(stand.backend)
    backend: Any = stand.backend
    backend.capabilities = lambda: ()
    with pytest.raises(FileError, match="DRIVE needs what the robot doesn't have: Base"):
        task.check_capabilities(stand.backend)


def repeated(**changes: str) -> str:
    text = TASK.replace("text: {parameter: word}", "text: {each: word}") + REPEAT
    for old, new in changes.items():
        text = text.replace(old, new)
    return text


def test_repeat_copies_the_part(load: Callable[..., Task]) -> None:
    network = load(repeated()).network
    assert list(network.situations) == ["a[1]", "a[2]", "a[3]", "b[1]", "b[2]", "b[3]", "z"]
    assert [str(a) for a in network.actions][3:6] == [
        "THINK (b[1] to a[2])",
        "THINK (b[2] to a[3])",
        "THINK (b[3] to z)",
    ]
    assert [fixed(a)["text"] for a in network.actions[:3]] == ["one", "two", "three"]


def test_repeat_skips_what_cannot_be_done(load: Callable[..., Task], stand: Stand) -> None:
    stand.script["x"] = deque("SP")
    network = load(repeated()).network
    cleared: list[float] = []
    events: list[Event] = []
    model: Any = stand.model
    model.clear_element = lambda: cleared.append(stand.robot.time)
    end = stand.finish(Coordinator(network, stand.robot, stand.model, observers=[events.append]))
    begun: list[Any] = [event.primitive for event in events if isinstance(event, Started)]
    texts = [primitive.text for primitive in begun]
    assert texts == ["one", "", "two", "three", ""]
    assert (end.outcome, end.exit_status, end.situation) == ("Fail", 3, "z")
    assert end.skipped == ("word[2] (two)",)
    assert end.reason == "left undone: word[2] (two)"
    assert len(cleared) == 3


def test_repeat_stops(load: Callable[..., Task], stand: Stand) -> None:
    stand.script["x"] = deque("SP")
    network = load(repeated(**{"unfinished: skip": "unfinished: stop"})).network
    end = stand.finish(Coordinator(network, stand.robot, stand.model))
    assert (end.outcome, end.situation, end.skipped) == ("Fail", "a[2]", ())


def test_elements_are_checked_at_their_own_place(load: Callable[..., Task]) -> None:
    found = findings(load, repeated(**{"[one, two, three]": "[one, 2, three]"}))
    assert [(line, "text is 2" in message) for line, message in found] == [(4, True)]


def test_elements_with_keys(load: Callable[..., Task]) -> None:
    text = repeated(**{"[one, two, three]": "[{w: one}, {w: two}]", "{each: word}": "{each: word.w}"})
    assert [fixed(a)["text"] for a in load(text).network.actions[:2]] == ["one", "two"]
    found = findings(load, text.replace("{w: two}", "{v: two}"))
    assert "unknown element 'word.w'" in found[0][1]


def test_two_hundred_situations_are_a_page(load: Callable[..., Task]) -> None:
    words = ", ".join(f"w{n}" for n in range(100))
    text = repeated(**{"one, two, three": words})
    assert len(text.splitlines()) < 30
    assert len(load(text).network.situations) == 201


def test_a_way_into_the_middle_of_the_part(load: Callable[..., Task]) -> None:
    text = repeated(**{"start: a\ngoal": "start: s\ngoal", "  a: {": "  s: {book: here}\n  a: {"})
    text = text.replace("repeat:", "  - {do: THINK, from: s, to: b, cost_s: 1, with: {name: q}}\nrepeat:")
    assert any("into the middle" in message for _, message in findings(load, text))


def test_start_and_goal_of_a_part_may_be_the_same(load: Callable[..., Task], stand: Stand) -> None:
    text = repeated(**{"goal: z\n  unf": "goal: a\n  unf", "to: z": "to: a"})
    text = text.replace("repeat:", "  - {do: THINK, from: a, to: z, cost_s: 1, with: {name: q}}\nrepeat:")
    with pytest.raises(FileError):
        load(text)  # the part would hold the task's own goal


def test_shipped_tasks_are_found_from_their_own_folder(load: Callable[..., Task], tmp_path: Path) -> None:
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "world.yaml").write_text("x: 1")
    task = load(TASK.replace("robot: librarian", "robot: librarian\nworld: ../other/world.yaml"))
    assert task.path("world") == (tmp_path / "other" / "world.yaml").resolve()
    assert task.path("knowledge", "map") is None
    assert isinstance(task.path("world"), Path)


@pytest.mark.parametrize(
    ("parameters", "expected"),
    [
        ("word: {parameter: word}", "'word' refers to itself: word, word; allowed"),
        (
            "word: {parameter: b}, b: [{parameter: c}], c: {parameter: word}",
            "itself: word, b, c, word",
        ),
        (
            "word: {parameter: b}, b: {parameter: wrod}",
            "unknown parameter 'wrod'; did you mean 'word'?",
        ),
        (
            ", ".join(f"p{n}: {{parameter: p{n + 1}}}" for n in range(40))
            + ", p40: x, word: {parameter: p0}",
            "more than 32 parameters refer to each other",
        ),
    ],
)
def test_parameters_in_a_circle_are_told(load: Callable[..., Task], parameters: str, expected: str) -> None:
    """T12: once, where the circle closes."""
    found = findings(load, TASK.replace("word: hello, words", f"{parameters}, words"))
    assert [line for line, message in found if expected in message] == [4]


def test_a_parameter_stands_for_another_one_a_few_steps_on(load: Callable[..., Task]) -> None:
    text = TASK.replace("word: hello", "word: {parameter: b}, b: {parameter: c}, c: bye")
    assert fixed(load(text).network.actions[0])["text"] == "bye"
    assert fixed(load(text, b="hi").network.actions[0])["text"] == "hi"


@pytest.mark.parametrize(
    ("lists", "expected"),
    [
        (
            ["[" + ", ".join(["{parameter: b}"] * 300) + "]", "[" + "x, " * 300 + "x]"],
            "more than 50000 values",
        ),
        (["[[[[[[[[{parameter: b}]]]]]]]]", "[" * 27 + "x" + "]" * 27], "deeper than 32 levels"),
    ],
)
def test_parameters_in_parameters_are_no_bomb(
    load: Callable[..., Task], lists: list[str], expected: str
) -> None:
    """T3, T4: of small lists in lists millions of values could be made."""
    found = findings(load, TASK.replace("word: hello", f"word: hello, a: {lists[0]}, b: {lists[1]}"))
    assert len(found) == 1
    assert expected in found[0][1]
    assert found[0][0] == 4


LATE = """\
format: handcart-task/1
title: Think of a book
robot: librarian
start: a
goal: z
situations: {a: {at: here}, b: {at: there}, c: {at: there}, z: {at: goal}}
actions:
  - {do: LOOK, from: a, to: b, cost_s: 1}
  - {do: THINK, from: b, to: c, cost_s: 1, with: {name: {model: book.title}}}
  - {do: THINK, from: c, to: z, cost_s: 1, with: {name: y}}
"""


class Look(ActionPrimitive):
    writes: ClassVar = ("book",)
    only_knowledge: ClassVar = True

    def motion(self, robot: Robot, model: ModelView) -> Periods:
        return
        yield


@pytest.mark.parametrize(
    ("old", "new", "good"),
    [
        ("start: a", "start: a", True),
        ("do: LOOK, from: a", "do: THINK, with: {name: x}, from: a", False),
        # An error at run time would come too late.
        ("do: LOOK, from: a, to: b", "do: THINK, with: {name: x}, from: a, to: b", False),
        ("do: LOOK, from: a, to: b", "do: LOOK, from: b, to: a", True),  # there and back
        (
            "from: a, to: b, cost_s: 1}",
            "from: a, to: a, cost_s: 1}\n  - {do: DRIVE, from: a, to: b, cost_s: 1}",
            True,
        ),
    ],
)
def test_what_nothing_finds_out_is_told(
    load: Callable[..., Task], primitives: SimpleNamespace, old: str, new: str, good: bool
) -> None:
    """T12: `{model: book.title}` where no action that could come before writes `book`."""
    primitives.LOOK = Look
    text = LATE.replace(old, new)
    if "from: b, to: a" in text:
        text = text.replace("start: a", "start: b")
    if good:
        assert load(text)
        return
    text = text.replace("with: {name: y}", "with: {name: y}}\n  - {do: LOOK, from: z, to: z, cost_s: 1")
    ((line, message),) = findings(load, text)
    assert line == 9
    assert message.startswith("name: nothing that is done before finds out 'book.title'; needed: before it")
