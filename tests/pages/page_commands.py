"""Command lines and snippets of the pages in docs/, and how a test runs them as a reader would."""

from __future__ import annotations

import re
from pathlib import Path
from typing import NamedTuple

from tests.tutorials.tutorial_steps import BLOCK as TUTORIAL_BLOCK

ROOT = Path(__file__).resolve().parents[2]
BLOCK = re.compile(r"```(?P<kind>[a-z]+)[^\n]*\n(?P<text>.*?)```", re.S)
SHELLS = ("bash", "sh", "console")
GENERATED = ("commands.md", "files.md", "primitives.md", "backends.md")  # made by the site
OWN_TESTS = {
    "docs/how_to/robots.md": "tests/test_robots_document.py",
    "docs/how_to/add_a_sensor.md": "tests/test_add_a_sensor.py",
    "docs/explanation/localization.md": "tests/tutorials/test_examples.py",
}
"""Pages whose commands a test file of their own runs."""


class Snippet(NamedTuple):
    """A block of a page that is set as code."""

    page: str
    line: int
    kind: str
    text: str


def pages() -> list[str]:
    """Return the written pages, relative to the repository; tutorials have tests of their own."""
    found = [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")]
    names = sorted(str(page.relative_to(ROOT)) for page in found if page.name not in GENERATED)
    return [name for name in names if not name.startswith("docs/tutorials/")]


def snippets(page: str) -> list[Snippet]:
    """Return the blocks of a page that name their language."""
    text = (ROOT / page).read_text(encoding="utf-8")
    return [
        Snippet(page, text.count("\n", 0, block.start()) + 2, block["kind"], block["text"])
        for block in BLOCK.finditer(text)
    ]


def shown_files(page: str) -> list[tuple[str, str]]:
    """Return path and content of each file that a page shows with its path as the caption."""
    text = (ROOT / page).read_text(encoding="utf-8")
    return [(block["file"], block["text"]) for block in TUTORIAL_BLOCK.finditer(text) if block["file"]]


def command_lines(page: str) -> list[str]:
    """Return the commands of a page that begin with `handcart` or `python -m`, without their comments."""
    shells = [snippet for snippet in snippets(page) if snippet.kind in SHELLS]
    lines = [line.strip() for snippet in shells for line in snippet.text.splitlines()]
    lines = [part.strip() for line in lines for part in line.removeprefix("$ ").split("&&")]
    lines = [re.sub(r"\s+#.*", "", line.replace(".venv/bin/", "")) for line in lines]
    return [line for line in lines if re.match(r"handcart |python (-m|scripts|examples)", line)]
