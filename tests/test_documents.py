"""Pages, README and site: links lead somewhere, commands exist, shown tasks are right, the site builds."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
GENERATED = {"commands.md", "files.md", "primitives.md", "backends.md"}  # of docs/reference, made by the site
PAGES = sorted(
    str(page.relative_to(ROOT))
    for page in (*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md"))
    if not (page.parent.name == "reference" and page.name in GENERATED)
)
MAX_PROSE_LINES = 45  # one screen


@pytest.mark.parametrize("page", PAGES)
def test_links_lead_somewhere(page: str) -> None:
    path = ROOT / page
    links = re.findall(r"\]\(([^)#\s]+)", path.read_text(encoding="utf-8"))
    local = [link for link in links if not re.match(r"https?:|mailto:", link)]
    made = {ROOT / "docs" / "reference" / name for name in GENERATED}
    missing = [link for link in local if not (path.parent / link).exists()]
    assert [link for link in missing if Path(os.path.normpath(path.parent / link)) not in made] == []


@pytest.mark.parametrize("page", PAGES)
def test_commands_in_pages_exist(page: str) -> None:
    from handcart.tools.command_line import all_commands

    shown = re.findall(r"`handcart ([a-z][\w-]*)", (ROOT / page).read_text(encoding="utf-8"))
    assert set(shown) <= {name.split()[0] for name in all_commands()}


@pytest.mark.parametrize("page", [page for page in PAGES if page.startswith("docs/")])
def test_pages_show_something_within_one_screen(page: str) -> None:
    lines = (ROOT / page).read_text(encoding="utf-8").splitlines()
    shown = [number for number, line in enumerate(lines) if re.match(r"```|:::|\||!\[|- ", line.strip())]
    assert shown
    assert shown[0] <= MAX_PROSE_LINES


@pytest.mark.parametrize("page", ["README.md", "docs/reference/tasks.md"])
def test_tasks_in_pages_are_right(tmp_path: Path, page: str) -> None:
    from handcart.networks.runs.run import prepare

    text = (ROOT / page).read_text(encoding="utf-8")
    blocks = [block for block in re.findall(r"```yaml\n(.*?)```", text, re.S) if "handcart-task/" in block]
    for source in (ROOT / "tasks" / "return_book").iterdir():
        if source.is_file():
            (tmp_path / source.name).write_bytes(source.read_bytes())
    for block in blocks:
        (tmp_path / "shown.yaml").write_text(block, encoding="utf-8")
        with prepare(tmp_path / "shown.yaml") as prepared:
            assert prepared.task.network.goal == "at_shelf"
    assert len(blocks) == 1


@pytest.mark.slow
def test_site_builds_without_a_warning(tmp_path: Path) -> None:
    words = [
        sys.executable,
        "-m",
        "sphinx",
        "-W",
        "-q",
        "-b",
        "dirhtml",
        str(ROOT / "docs"),
        str(tmp_path / "site"),
    ]
    built = subprocess.run(words, capture_output=True, text=True, check=False)
    assert (built.returncode, built.stderr) == (0, "")
    pages = {
        str(page.parent.relative_to(tmp_path / "site")) for page in (tmp_path / "site").rglob("index.html")
    }
    assert {"reference/commands", "reference/files", "reference/python", "how_to/robots"} <= pages
