"""Networks as Mermaid, dot and SVG."""

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
