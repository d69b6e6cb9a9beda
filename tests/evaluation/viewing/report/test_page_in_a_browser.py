from __future__ import annotations

from pathlib import Path

import pytest

from handcart.evaluation.trials.running import run_task
from handcart.networks.runs.run_options import RunOptions
from tests.browser import DESK, PHONE, browsing, needs_browser

TOUR = Path(__file__).parents[4] / "tasks" / "drive_map" / "task.yaml"


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    runs = tmp_path_factory.mktemp("runs")
    options = RunOptions(settings={"robot": "cart", "tour": "[desk]"}, draw=True, report=True)
    summary, status = run_task(TOUR, runs, options)
    assert status == 0
    return Path(summary["run_dir"]) / "report.html"


@needs_browser
@pytest.mark.slow
@pytest.mark.parametrize("size", [PHONE, DESK])
def test_page_loads_nothing_logs_nothing_and_fits_the_width(page: Path, size: tuple[int, int]) -> None:
    with browsing(size) as seen:
        seen.page.goto(page.as_uri())
        seen.page.wait_for_load_state("networkidle")
        wide = seen.page.evaluate("document.documentElement.scrollWidth")
        pictures = seen.page.evaluate(
            "Array.from(document.images).map(each => each.complete && each.naturalWidth)"
        )
    assert [url for url in seen.requests if not url.startswith("data:")] == [page.as_uri()]
    assert seen.errors == []
    assert wide <= size[0]
    assert pictures
    assert all(pictures)
