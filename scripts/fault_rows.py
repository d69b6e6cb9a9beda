"""Tests that cover each row of docs/reference/faults.md: `python scripts/fault_rows.py`.

A test names its rows in its docstring (`N9: ...`) or in its name (`test_t03_...`).
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

REPOSITORY_ROOT = Path(__file__).resolve().parents[1]
FAULTS_PAGE = REPOSITORY_ROOT / "docs" / "reference" / "faults.md"
_ROW = re.compile(r"\b([TNABSCDKU][1-9]\d?)\b")
_IN_NAME = re.compile(r"^test_([tnabscdku])0?([1-9]\d?)_")
_TOLD = re.compile(r"^\| ([TNABSCDKU][1-9]\d?) \|", re.M)


def rows() -> list[str]:
    """Return the rows that the document claims."""
    return _TOLD.findall(FAULTS_PAGE.read_text(encoding="utf-8"))


def tests_by_row() -> dict[str, list[str]]:
    """Return the tests that name each row, as pytest calls them."""
    found: dict[str, list[str]] = {}
    for path in sorted((REPOSITORY_ROOT / "tests").rglob("test_*.py")):
        for test in _tests(ast.parse(path.read_text(encoding="utf-8"))):
            for row in _named(test):
                found.setdefault(row, []).append(f"{path.relative_to(REPOSITORY_ROOT)}::{test.name}")
    return found


def _tests(tree: ast.Module) -> Iterator[ast.FunctionDef]:
    return (node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef) and node.name[:5] == "test_")


def _named(test: ast.FunctionDef) -> set[str]:
    in_name = {f"{kind.upper()}{number}" for kind, number in _IN_NAME.findall(test.name)}
    return in_name | set(_ROW.findall(ast.get_docstring(test) or ""))


def main() -> None:
    """Print the table."""
    covered = tests_by_row()
    for row in rows():
        first, *more = covered.get(row, ["no test names it"])
        print(f"{row:<4} {first}")
        for item in more:
            print(f"     {item}")


if __name__ == "__main__":
    main()
