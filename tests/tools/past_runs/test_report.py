from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import orjson
import pytest

from tests.tools.conftest import Said


@pytest.mark.slow
def test_a_run_leaves_one_page_that_needs_nothing_else(
    handcart: Callable[..., Said], tour: Path, tmp_path: Path
) -> None:
    title = 'Tour <script src="x"></script> & back'
    text = re.sub("title: .*", f"title: '{title}'", tour.read_text(encoding="utf-8"))
    tour.write_text(text, encoding="utf-8")
    assert handcart("run", tour, "--runs", tmp_path / "runs").status == 0
    page = (tmp_path / "runs" / "latest" / "report.html").read_text(encoding="utf-8")
    assert "Success in situation at_shelf" in page
    assert "cheapest way to the goal" in page
    assert "<script" not in page
    assert f"Again: <code>handcart run {tour} --seed 0</code>" in page
    sources = re.findall(r'(?:src|href)="([^"]*)"', page)
    assert sources
    assert all(source.startswith(("data:image/", "#action-")) for source in sources)
    assert all(f'id="{source[1:]}"' in page for source in sources if source.startswith("#"))
    summary = orjson.loads((tmp_path / "runs" / "latest" / "summary.json").read_bytes())
    assert f'<td>actions</td><td class="n">{summary["actions"]}</td>' in page

    said = handcart("report", tmp_path / "runs" / "tour-0", "-o", tmp_path / "other.html")
    assert said.status == 0
    assert (tmp_path / "other.html").read_text(encoding="utf-8") == page
    said = handcart("report", tmp_path / "runs" / "tour-0", "-o", tmp_path / "other.txt")
    assert (said.status, ".txt" in said.err, "*.html" in said.err) == (2, True, True)


@pytest.mark.slow
def test_report_is_optional_and_a_missing_run_is_no_traceback(
    handcart: Callable[..., Said], tour: Path, tmp_path: Path
) -> None:
    assert handcart("run", tour, "--no-report", "--runs", tmp_path / "runs").status == 0
    assert not (tmp_path / "runs" / "tour-0" / "report.html").exists()
    said = handcart("report", tmp_path / "nothing")
    assert said.status == 2
    assert "there is no such folder" in said.err


def test_the_command_to_repeat_a_run_names_where_and_when_it_began(
    handcart: Callable[..., Said], tour: Path, tmp_path: Path
) -> None:
    interrupts = 'interrupts: [{name: noon, when: {at: "12:00"}, goal: at_home}]\n'
    tour.write_text(tour.read_text(encoding="utf-8") + interrupts, encoding="utf-8")
    more = ("--from", "at_shelf", "--begins-at", "07:30")
    assert handcart("run", tour, *more, "--runs", tmp_path / "runs").status == 0
    page = (tmp_path / "runs" / "latest" / "report.html").read_text(encoding="utf-8")
    assert f"Again: <code>handcart run {tour} --from at_shelf --begins-at 07:30:00 --seed 0</code>" in page
