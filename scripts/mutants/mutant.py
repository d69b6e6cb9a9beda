"""One planted bug, and the tables that hold them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import takewhile
from pathlib import Path

from ruamel.yaml import YAML

TABLE_FOLDER = Path(__file__).parent / "table"


@dataclass(frozen=True)
class Mutant:
    """Bug that could have been written, and the tests that have to notice it."""

    name: str
    """What is wrong with it, in a few words."""
    file: str
    """Path in the project."""
    text: str
    """Original text, which occurs once in the file."""
    replacement: str
    tests: tuple[str, ...]
    """Nearest tests, as pytest takes them."""

    def planted(self, content: str) -> str:
        """Return the file's content with the bug; raises `ValueError` where the text isn't there exactly
        once.
        """
        found = content.count(self.text)
        if found != 1:
            raise ValueError(f"{self.file}: {self.name}: the text is there {found} times; needed: once")
        return content.replace(self.text, self.replacement)


def read_table(table: Path = TABLE_FOLDER, files: str = "*.yaml") -> list[Mutant]:
    """Return all mutants of a folder's files that match a pattern, in the files' order."""
    return [mutant for path in sorted(table.glob(files)) for mutant in _read(path)]


def _read(path: Path) -> Iterator[Mutant]:
    for file in YAML(typ="safe").load(path.read_text(encoding="utf-8")):
        tests = tuple(file["tests"])
        for bug in file["bugs"]:
            own = tuple(bug.get("tests", tests))
            name = bug.get("name") or _in_a_line(bug["text"], bug["replacement"])
            yield Mutant(name, file["file"], bug["text"], bug["replacement"], own)


def _in_a_line(text: str, replacement: str) -> str:
    """Return the change as "old -> new", without the common beginning and end."""
    front = _alike(text, replacement)
    back = _alike(text[front:][::-1], replacement[front:][::-1])
    cut = [" ".join(item[front : len(item) - back].split()) for item in (text, replacement)]
    return " -> ".join(item or "nothing" for item in cut)


def _alike(a: str, b: str) -> int:
    """Return the number of characters with which both texts begin."""
    return sum(1 for _ in takewhile(lambda pair: pair[0] == pair[1], zip(a, b, strict=False)))
