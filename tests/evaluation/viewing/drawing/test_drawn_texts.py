"""No text of a shipped picture, or of one that a run leaves, lies over another or is clipped."""

from __future__ import annotations

from pathlib import Path

import pytest

from handcart.evaluation.trials.running import run_task
from handcart.networks.runs.run_options import RunOptions
from tests.browser import DESK, PHONE, browsing, needs_browser
from tests.drawn_texts import faults_of_page

pytestmark = needs_browser

ROOT = Path(__file__).parents[4]
SHIPPED = sorted((ROOT / "docs" / "pictures").glob("*.svg"))
RUNS = (  # with a Fail each where there is one
    ("return_book/task.yaml", 5),
    ("stack_blocks/task.yaml", 0),
    ("track_seam/task.yaml", 0),
    ("track_seam/driving.yaml", 0),
    ("deploy_zigzag/task.yaml", 0),
    ("drive_map/task.yaml", 0),
)


@pytest.mark.slow
def test_shipped_pictures() -> None:
    assert SHIPPED
    with browsing(DESK) as seen:
        found = {}
        for picture in SHIPPED:
            seen.page.goto(picture.as_uri())
            found[picture.name] = faults_of_page(seen.page)
    assert {name: faults for name, faults in found.items() if faults} == {}


def test_texts_over_each_other_are_noticed(tmp_path: Path) -> None:
    (tmp_path / "bad.svg").write_text(
        '<svg xmlns="http://www.w3.org/2000/svg" width="90" height="40"><text x="4" y="20">one</text>'
        '<text x="10" y="22">two</text><text x="70" y="20">clipped</text></svg>'
    )
    with browsing(DESK) as seen:
        seen.page.goto((tmp_path / "bad.svg").as_uri())
        assert sorted(faults_of_page(seen.page)) == ["clipped is clipped", "one lies over two"]


@pytest.mark.slow
@pytest.mark.parametrize(("task", "seed"), RUNS)
def test_pictures_of_a_run(tmp_path: Path, task: str, seed: int) -> None:
    options = RunOptions(seed=seed, draw=True, report=True)
    folder = Path(run_task(ROOT / "tasks" / task, tmp_path, options)[0]["run_dir"])
    pictures = sorted(folder.rglob("*.svg"))
    assert folder / "overview.svg" in pictures
    found = {}
    for size in (DESK, PHONE):
        with browsing(size) as seen:
            for file in (*pictures, folder / "report.html"):
                if file.suffix == ".svg" and size is PHONE:
                    continue
                seen.page.goto(file.as_uri())
                found[f"{file.name} {size}"] = faults_of_page(seen.page)
            assert seen.errors == []
    assert {name: faults for name, faults in found.items() if faults} == {}
