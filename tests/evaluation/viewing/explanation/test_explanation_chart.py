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
