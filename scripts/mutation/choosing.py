"""The tests that are to notice a mutant: those that execute its line, or else those nearest to its file."""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator
from functools import cache
from pathlib import Path

from coverage import CoverageData

MAX_FILES = 8
"""Files of tests that are run for one mutant."""


def tests_by_coverage(project: Path, data: CoverageData, file: str, line: int) -> list[str]:
    """Return files of tests that execute a line, by what coverage.py noted in one run of the suite.

    Args:
        project: folder that file names are relative to.
        data: read from a data file, with `dynamic_context = test_function`; empty: nothing is known.
        file: the source.
        line: in it; lines of imports and of fixtures have no tests of their own.
    """
    path = next((each for each in data.measured_files() if each.endswith(f"/{file}")), None)
    contexts = data.contexts_by_lineno(path).get(line, []) if path else []
    known = {each for context in contexts if (each := _file_of(project, context))}
    return sorted(known, key=lambda test: (-_shared(file, test), test))


def _file_of(project: Path, context: str) -> str:
    """Return the file of a test function as `tests.files.test_x.test_y`; empty if there is none."""
    parts = context.split(".")
    names = ("/".join(parts[:end]) + ".py" for end in range(len(parts) - 1, 0, -1))
    return next((name for name in names if (project / name).is_file()), "")


def nearest_tests(project: Path, file: str) -> list[str]:
    """Return files of tests, nearest first: of that name, importing it, beside those, two imports away."""
    module, stem = "handcart." + file.removesuffix(".py").replace("/", "."), Path(file).stem
    importers = _importers(project)
    direct = {each for each in importers.get(module, ()) if each.startswith("tests/")}
    beside = {
        path.relative_to(project).as_posix()
        for path in (project / "tests" / Path(file).parent).glob("test_*.py")
    }
    far = {
        test
        for source in importers.get(module, ())
        if not source.startswith("tests/")
        for test in importers.get("handcart." + source.removesuffix(".py").replace("/", "."), ())
        if test.startswith("tests/")
    }

    def nearness(test: str) -> tuple[object, ...]:
        return (
            Path(test).stem != f"test_{stem}",
            test not in direct,
            test not in beside,
            -_shared(file, test),
            (project / test).stat().st_size,
        )

    tests = {each for each in direct | beside | far if Path(each).name.startswith("test_")}
    return sorted(tests, key=lambda test: (nearness(test), test))


def _shared(file: str, test: str) -> int:
    """Return how many folders a file and a file of tests share."""
    own, other = Path(file).parent.parts, Path(test).parent.parts[1:]
    return sum(1 for _ in _alike(own, other))


def _alike(one: Iterable[str], other: Iterable[str]) -> Iterator[str]:
    for a, b in zip(one, other, strict=False):
        if a != b:
            return
        yield a


@cache
def _importers(project: Path) -> dict[str, set[str]]:
    """Return, for each module, the files that import it or a name of it."""
    found: dict[str, set[str]] = {}
    for path in project.rglob("*.py"):
        name = path.relative_to(project).as_posix()
        if name.startswith((".", "src/", "build/")):
            continue
        for module in _imported(name, ast.parse(path.read_text(encoding="utf-8"))):
            found.setdefault(module, set()).add(name)
    return found


def _imported(name: str, tree: ast.Module) -> Iterator[str]:
    package = ["handcart", *Path(name).parent.parts]
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        if isinstance(node, ast.ImportFrom):
            base = package[: len(package) - node.level + 1] if node.level else []
            module = ".".join([*base, *(node.module or "").split(".")]).strip(".")
            yield module
            yield from (f"{module}.{alias.name}" for alias in node.names)
