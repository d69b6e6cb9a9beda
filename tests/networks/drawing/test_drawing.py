"""Networks as Mermaid, dot and SVG."""

from itertools import pairwise
from typing import Any
from xml.etree import ElementTree

import pytest

from handcart.networks.drawing.drawing import WRITER_BY_SUFFIX
from handcart.networks.graph.network import Action, ActionNetwork, Binding, Situation
from tests.networks.conftest import Stand


@pytest.fixture
def network(stand: Stand) -> ActionNetwork:
    def action(source: str, target: str, **more: Any) -> Action:
        return Action(source, target, Binding.of(stand.Think(name="x")), **more)

    facts = {"book": 'a "b" <c> & d'}
    situations = [
        Situation("s", facts),
        Situation("k", facts),
        Situation("m"),
        Situation("z"),
        Situation("far"),
    ]
    actions = [
        action("s", "m", on_fail="k", cost_s=2.5),
        action("s", "m"),
        action("k", "k"),
        action("k", "m"),
        action("m", "s"),
        action("m", "z"),
        action("s", "z"),
        Action("s", "z", None),
    ]
    return ActionNetwork.build(situations, actions, "s", "z")


@pytest.mark.parametrize("suffix", [".svg", ".mmd", ".dot"])
def test_everything_is_drawn(network: ActionNetwork, suffix: str) -> None:
    text = WRITER_BY_SUFFIX[suffix](network, "")
    assert isinstance(text, str)
    for situation in network.situations:
        assert situation in text
    assert "2.5 s" in text
    assert "SKIP" in text
    assert WRITER_BY_SUFFIX[suffix](network, "") == text


def test_a_declared_fail_is_drawn_once(network: ActionNetwork) -> None:
    for suffix, words in ((".mmd", "THINK fails"), (".dot", "THINK fails"), (".svg", "stroke-dasharray")):
        assert str(WRITER_BY_SUFFIX[suffix](network, "")).count(words) == 1


def test_svg_is_xml(network: ActionNetwork) -> None:
    root = ElementTree.fromstring(WRITER_BY_SUFFIX[".svg"](network, "a < b"))
    kinds = [element.get("class", "") for element in root.iter()]
    assert sum(kinds.count(kind) for kind in ("situation", "start", "goal")) == 5
    assert kinds.count("action") == 8
    assert kinds.count("link") == 17


@pytest.mark.parametrize(("suffix", "begin"), [(".png", b"\x89PNG"), (".pdf", b"%PDF")])
def test_pictures_are_the_same_each_time(network: ActionNetwork, suffix: str, begin: bytes) -> None:
    picture = WRITER_BY_SUFFIX[suffix](network, "think")
    assert isinstance(picture, bytes)
    assert picture.startswith(begin)
    assert WRITER_BY_SUFFIX[suffix](network, "think") == picture


@pytest.mark.parametrize("suffix", [".svg", ".mmd", ".dot"])
@pytest.mark.parametrize("count", [1, 2, 3])
def test_part_of_few_elements_with_long_values_is_drawn(stand: Stand, suffix: str, count: int) -> None:
    values = [str(number) * 50 for number in range(count)]
    names = [f"at[{number}]" for number in range(count)]
    inside = [
        Situation(name, {}, f"book[{number + 1}] ({value})")
        for number, (name, value) in enumerate(zip(names, values, strict=True))
    ]
    ways = [
        Action(source, target, Binding.of(stand.Think(name="x")))
        for source, target in pairwise(["s", *names, "z"])
    ]
    network = ActionNetwork.build([Situation("s"), *inside, Situation("z")], ways, "s", "z")
    times = "1 time" if count == 1 else f"{count} times"
    assert f"for each book, {times}: 0000" in str(WRITER_BY_SUFFIX[suffix](network, ""))


@pytest.mark.parametrize("suffix", [".svg", ".mmd", ".dot", ".png"])
def test_value_of_several_lines_is_drawn_on_one(stand: Stand, suffix: str) -> None:
    situations = [Situation("s", {"note": "one\ntwo\a"}), Situation("z")]
    ways = [Action("s", "z", Binding.of(stand.Think(name="x")))]
    drawn = WRITER_BY_SUFFIX[suffix](ActionNetwork.build(situations, ways, "s", "z"), "a\nb\a")
    if isinstance(drawn, str):
        assert "note: one two\ufffd" in drawn
    if suffix == ".svg":
        ElementTree.fromstring(str(drawn))


def test_mermaid_shows_tags_and_hashes_as_they_are(stand: Stand) -> None:
    situations = [Situation("s", {"note": "<i>#35; a\\b"}), Situation("z")]
    ways = [Action("s", "z", Binding.of(stand.Think(name="x")))]
    drawn = WRITER_BY_SUFFIX[".mmd"](ActionNetwork.build(situations, ways, "s", "z"), "")
    assert "note: &lt;i&gt;#35;35; a\\b" in str(drawn)
