"""Texts of users are drawn as they are, not read as mathematics."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest

from handcart.evaluation.viewing.drawing.figure_file import save_figure
from handcart.evaluation.viewing.drawing.place_arrows import draw_places
from handcart.evaluation.viewing.explanation.explanation_chart import draw_chart


@pytest.mark.parametrize("name", ["$_$", "a $5 and $6 b", r"one \$ and $"])
def test_a_place_named_with_dollars_is_drawn_as_it_is(tmp_path: Path, name: str) -> None:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(6.0, 6.0))
    axis = figure.add_subplot()
    axis.set(xlim=(0.0, 10.0), ylim=(0.0, 10.0))
    draw_places(axis, {name: (5.0, 5.0, 0.0)})
    save_figure(figure, tmp_path / "places.svg")
    assert f">{name}</text>" in (tmp_path / "places.svg").read_text(encoding="utf-8")


def test_an_explanation_with_dollars_is_drawn_as_it_is(tmp_path: Path) -> None:
    measured = {"sensor": "Arm", "what": "$_$", "value": 2.0, "limit": 1.0, "unit": "N"}
    cause = {"reason": "no $^$ here", "check": "motion", "calls": [], "measured": measured}
    action = SimpleNamespace(number=1, do="PICK", outcome="Fail", reason="$5^$", broken_off=None, end=1.0)
    explanation: Any = SimpleNamespace(
        run=SimpleNamespace(folder=tmp_path),
        action=action,
        causes=[cause],
        picture=None,
        points=None,
        readings=None,
    )
    draw_chart(cast("Any", explanation), tmp_path / "chart.svg")
    drawn = (tmp_path / "chart.svg").read_text(encoding="utf-8")
    assert "PICK Fail: $5^$" in drawn
    assert "no $^$ here" in drawn
    assert "Arm: $_$ 2" in drawn
