"""Drawing of what decided, seen from above."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from handcart.evaluation.viewing.explanation.explanation import Explanation
from handcart.evaluation.viewing.explanation.explanation_chart import _draw_plan

PLACES = np.array([[2.0, 3.0], [17.5, -6.0]])


def test_each_place_that_the_robot_may_be_at_is_drawn_and_in_view(tmp_path: Path) -> None:
    from matplotlib.figure import Figure

    np.savez(tmp_path / "points.npz", scan=np.zeros((3, 2)), hypotheses=PLACES)
    axis = Figure().add_subplot()
    explanation = cast("Any", SimpleNamespace(points=tmp_path / "points.npz"))
    _draw_plan(axis, cast("Explanation", explanation), {})
    (drawn,) = [line for line in axis.get_lines() if line.get_label() == "may be here"]
    assert np.asarray(drawn.get_xydata()) == pytest.approx(PLACES)
    (left, right), (low, high) = axis.get_xlim(), axis.get_ylim()
    assert all(left < x < right and low < y < high for x, y in PLACES)


@pytest.mark.parametrize(("way_m", "labels"), [(0.0, []), (0.5, ["driven"])])
def test_a_way_is_named_only_if_the_base_was_driven(way_m: float, labels: list[str]) -> None:
    from matplotlib.figure import Figure

    times = np.linspace(0.0, 1.0, 11)
    readings = {"time_s": times, "x_m": way_m * times, "y_m": 0.0 * times, "heading_rad": 0.0 * times}
    axis = Figure().add_subplot()
    explanation = cast("Any", SimpleNamespace(points=None, action=None))
    _draw_plan(axis, cast("Explanation", explanation), readings)
    assert [
        line.get_label() for line in axis.get_lines() if not str(line.get_label()).startswith("_")
    ] == labels
