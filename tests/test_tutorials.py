"""Tutorials work as pasted: their files are written and their commands run, in order, in an empty folder.

A block with a caption is a file. A command whose line ends in `# status N` exits with N.
"""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator
from pathlib import Path

import pytest

from handcart.tools.main import main

FOLDER = Path(__file__).resolve().parents[1] / "docs" / "tutorials"
TUTORIALS = sorted(page.name for page in FOLDER.glob("*.md") if page.name != "index.md")
BLOCK = re.compile(
    r"```(?:\{code-block\} \w+\n:caption: (?P<file>\S+)\n\n?|(?P<kind>bash)\n)(?P<text>.*?)```", re.S
)


def steps(page: str) -> Iterator[tuple[str, str]]:
    """Yield the files and commands of a page: (path, text) of a file, ("", line) of a command."""
    for block in BLOCK.finditer((FOLDER / page).read_text(encoding="utf-8")):
        if block["file"]:
            yield block["file"], block["text"]
        else:
            yield from (("", line) for line in block["text"].splitlines() if line.strip())


@pytest.mark.slow
@pytest.mark.parametrize("page", TUTORIALS)
def test_tutorial_works_as_pasted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, page: str) -> None:
    monkeypatch.chdir(tmp_path)
    done = 0
    for path, text in steps(page):
        if path:
            (tmp_path / path).parent.mkdir(parents=True, exist_ok=True)
            (tmp_path / path).write_text(text, encoding="utf-8")
            continue
        line, _, expected = text.partition(" # status ")
        program, *words = shlex.split(line)
        assert program == "handcart", line
        with pytest.raises(SystemExit) as end:
            main(words)
        assert (end.value.code or 0) == int(expected or 0), line
        done += 1
    assert done >= 3
