"""Lists the benchmarks, each a command of its own: `python -m benchmarks [WORD]`."""

from __future__ import annotations

import argparse
import ast
import re
from collections.abc import Iterator
from pathlib import Path

from rich.console import Console
from rich.table import Table

BENCHMARKS_FOLDER = Path(__file__).parent


def listed(word: str = "") -> Iterator[tuple[str, str]]:
    """Name and first sentence of each module here that is a command and has the word in either."""
    for path in sorted(BENCHMARKS_FOLDER.rglob("*.py")):
        text = path.read_text(encoding="utf-8")
        if '__name__ == "__main__"' not in text or path == Path(__file__):
            continue
        name = ".".join(path.relative_to(BENCHMARKS_FOLDER.parent).with_suffix("").parts)
        about = re.split(r":\s+`?python", (ast.get_docstring(ast.parse(text)) or "").split("\n\n")[0])[0]
        if word.lower() in f"{name} {about}".lower():
            yield name, " ".join(about.split()).rstrip(".")


def main() -> None:
    """Print a table; status 1 where nothing fits."""
    words = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    words.add_argument("word", nargs="?", default="", help="only those with it in name or description")
    found = list(listed(words.parse_args().word))
    table = Table("python -m ...", "what it measures", box=None)
    for row in found:
        table.add_row(*row)
    Console().print(table)
    raise SystemExit(0 if found else 1)


if __name__ == "__main__":
    main()
