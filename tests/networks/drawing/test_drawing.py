"""Networks as Mermaid, dot and SVG."""

from typing import Any
from xml.etree import ElementTree

import pytest

from handcart.networks.drawing.drawing import FORMATS
from handcart.networks.drawing.layout import BOX, lay_out, lines_of
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


@pytest.mark.parametrize("suffix", FORMATS)
def test_everything_is_drawn(network: ActionNetwork, suffix: str) -> None:
    text = FORMATS[suffix](network)
    for situation in network.situations:
        assert situation in text
    assert text.count("THINK fails") == 1
    assert "2.5 s" in text
    assert "SKIP" in text
    assert FORMATS[suffix](network) == text


def test_svg_is_xml(network: ActionNetwork) -> None:
    root = ElementTree.fromstring(FORMATS[".svg"](network))
    kinds = [element.get("class", "") for element in root.iter()]
    assert kinds.count("box") + kinds.count("box start") + kinds.count("box goal") == 5
    assert sum(kind.startswith("way") for kind in kinds) == 9


def test_no_way_passes_through_a_box(network: ActionNetwork) -> None:
    layout = lay_out(network, lines_of(network))
    middles = list(layout.boxes.values())
    assert len(set(middles)) == len(middles)
    for points in layout.between:
        for point in points:
            assert all(abs(point.x - m.x) > 0.5 * BOX for m in middles if m.y == point.y)
