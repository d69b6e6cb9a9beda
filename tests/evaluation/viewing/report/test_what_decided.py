"""A run's page shows the measurement that decided a failed action."""

from __future__ import annotations

import base64
import math
import re
from pathlib import Path
from typing import Any

import pytest

from handcart.evaluation.books.library_files import Libraries
from handcart.evaluation.trials.running import run_task
from handcart.evaluation.viewing.report.report import _gauge
from handcart.networks.runs.run_options import RunOptions
from tests.browser import DESK, PHONE, axe_findings, browsing, needs_browser

TASK = Path(__file__).parents[4] / "tasks" / "return_book" / "task.yaml"


def measured(value: float | None, limit: float | None) -> dict[str, Any]:
    return {"sensor": "Arm", "what": "force", "value": value, "limit": limit, "unit": "N"}


def test_a_gauge_shows_what_decided_beside_its_limit_in_one_scale() -> None:
    gauge = _gauge(measured(8.0, 4.0))
    assert gauge is not None
    assert gauge["words"] == "Arm: force 8 N, needed: at most 4 N"
    assert gauge["value"] == pytest.approx(2.0 * gauge["limit"])
    assert 0.0 < gauge["limit"] < gauge["value"] < 1.0
    below = _gauge(measured(1.0, 4.0))
    assert below is not None
    assert below["limit"] == pytest.approx(4.0 * below["value"])


@pytest.mark.parametrize(
    "what",
    [
        None,
        measured(None, 4.0),
        measured(1.0, None),
        measured(0.0, 0.0),
        measured(-1.0, 1.0),
        measured(math.inf, 1.0),
        measured(math.nan, 1.0),
    ],
)
def test_what_has_no_scale_has_no_gauge(what: dict[str, Any] | None) -> None:
    assert _gauge(what) is None


@pytest.fixture(scope="module")
def blocked(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a run whose way was closed."""
    folder = tmp_path_factory.mktemp("blocked")
    settings = Libraries.model_validate({"blocked": "closed"})(0, folder / "library")
    options = RunOptions(settings=settings, draw=True, report=True)
    summary, status = run_task(TASK, folder / "runs", options)
    assert status == 3
    return Path(summary["run_dir"])


@pytest.mark.slow
def test_blocked_route_is_drawn_with_robot_and_obstacle(blocked: Path) -> None:
    page = (blocked / "report.html").read_text(encoding="utf-8")
    fails = page.count("When it decided, on the map")
    assert fails == len(list((blocked / "evidence").glob("*_Fail.svg"))) > 0
    assert page.count('class="gauge"') >= fails
    drawn = re.findall(r'class="drawn" src="data:image/svg\+xml;base64,([^"]*)"', page)
    assert all(b"robot when it decided" in base64.b64decode(item) for item in drawn)


@pytest.mark.slow
@needs_browser
@pytest.mark.parametrize("size", [PHONE, DESK])
def test_axe_finds_nothing(blocked: Path, size: tuple[int, int]) -> None:
    with browsing(size) as seen:
        seen.page.goto((blocked / "report.html").as_uri())
        seen.page.evaluate("document.querySelectorAll('details').forEach(each => { each.open = true; })")
        assert seen.page.evaluate("document.documentElement.scrollWidth") <= size[0]
        assert axe_findings(seen.page) == []
