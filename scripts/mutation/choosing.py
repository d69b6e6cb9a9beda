"""Choice of the tests for a mutant: those that execute its line, otherwise those nearest to its file."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable, Iterator, Sequence
from functools import cache
from pathlib import Path
from typing import NamedTuple

from recording import Recording

MAX_FILES = 8
"""Files of tests that are run for one mutant where no recording says which tests execute its line."""
NEW_FILES = 3
"""Nearest files of tests in which tests are looked for that are newer than the recording."""
NEARNESS_FACTOR = 4.0
"""Factor by which a test may take longer, for each folder shared with the file, and is still taken first."""


class ChosenTests(NamedTuple):
    """Tests for one mutant, in the order in which they run."""

    tests: list[tuple[str, float]]
    """Node ids with recorded durations, in [s]."""
    files: list[str]
    """Files of tests; those of their tests that have no record run first."""
    executing: bool = False
    """True if the tests are known to execute the line; otherwise they are those of the nearest files."""


def choose_tests(
    project: Path, recording: Recording | None, file: str, line: int, seconds: float, files: int = MAX_FILES
) -> ChosenTests:
    """Return tests that execute a line, cheap and near ones first, or without any the nearest files.

    Args:
        project: folder that file names are relative to.
        recording: which test executes which line; None: nothing is known.
        file: the source.
        line: in it, from 1.
        seconds: recorded time that the tests may take together; the first is taken in any case.
        files: number of files where nothing is known.
    """
    nearest = nearest_tests(project, file)
    if recording is None:
        return ChosenTests([], nearest[:files])
    names = executing = _executing(project, recording, file, line)
    if not names:  # compiled code, or another process, leaves no trace
        names = {name for name in recording.durations if name.split("::")[0] in nearest[:files]}
    durations = {name: recording.durations[name] for name in names}
    taken, total = [], 0.0
    for name in sorted(
        names, key=lambda name: (durations[name] / NEARNESS_FACTOR ** _shared(file, name), name)
    ):
        total += durations[name]
        if total > seconds and taken:
            break
        taken.append((name, durations[name]))
    return ChosenTests(taken, nearest[:NEW_FILES], bool(executing))


def _executing(project: Path, recording: Recording, file: str, line: int) -> set[str]:
    """Return tests that execute a statement; of one that runs at import, those that use what it defines."""
    source = (project / file).read_text(encoding="utf-8")
    by_line = recording.tests_of(file)
    statement = statement_at(ast.parse(source), line)
    found = {name for number in statement.lines for name in by_line.get(number, ())}
    if statement.is_imported:
        found = set()
        for other, numbers in _using(project, file, statement).items():
            of_other = recording.tests_of(other)
            found |= {name for number in numbers for name in of_other.get(number, ())}
        found = found or {name for names in by_line.values() for name in names}
    return {
        name for name in found if name in recording.durations and (project / name.split("::")[0]).exists()
    }


class Statement(NamedTuple):
    """A statement of a source."""

    lines: range
    """Its lines; of one with a body the lines before the body."""
    is_imported: bool
    """True if it is executed when the module is imported."""
    body: range
    """Lines of a function that begins here; otherwise empty."""
    names: tuple[str, ...]
    """Names that it binds."""


def statement_at(tree: ast.Module, line: int) -> Statement:
    """Return the innermost statement of a line."""
    path: list[ast.stmt] = []
    node: ast.AST = tree
    while True:
        inner = [
            statement
            for statement in _statements(node)
            if _first(statement) <= line <= (statement.end_lineno or 0)
        ]
        if not inner:
            break
        node = inner[-1]
        path.append(inner[-1])
    if not path:
        return Statement(range(line, line + 1), True, range(0), ())
    last = path[-1]
    functions = [stmt for stmt in path[:-1] if isinstance(stmt, ast.FunctionDef | ast.AsyncFunctionDef)]
    body = getattr(last, "body", None)
    end = _first(body[0]) if body else (last.end_lineno or line) + 1
    lines = range(_first(last), max(end, line + 1))
    is_function = isinstance(last, ast.FunctionDef | ast.AsyncFunctionDef)
    inside = range(end, (last.end_lineno or line) + 1) if is_function else range(0)
    return Statement(lines, is_function or not functions, inside, tuple(_bound(path)))


def _statements(node: ast.AST) -> Iterator[ast.stmt]:
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.stmt):
            yield child
        elif isinstance(child, ast.ExceptHandler | ast.match_case):
            yield from _statements(child)


def _first(node: ast.stmt) -> int:
    decorators = getattr(node, "decorator_list", [])
    return min([node.lineno, *(decorator.lineno for decorator in decorators)])


def _bound(path: Sequence[ast.stmt]) -> Iterator[str]:
    """Yield names that the last statement, or otherwise the class around it, binds."""
    last = path[-1]
    targets = getattr(last, "targets", [getattr(last, "target", None)])
    for target in targets:
        if target is not None:
            yield from (node.id for node in ast.walk(target) if isinstance(node, ast.Name))
    if isinstance(last, ast.ClassDef):
        yield last.name


def _using(project: Path, file: str, statement: Statement) -> dict[str, list[int]]:
    """Return, by file, the lines of a function, or those that mention what a statement binds."""
    if statement.body:
        return {file: list(statement.body)}
    if not statement.names:
        return {}
    pattern = re.compile(rf"\b(?:{'|'.join(statement.names)})\b")
    module = "handcart." + file.removesuffix(".py").replace("/", ".")
    others = [other for other in _importers(project).get(module, ()) if not other.startswith("tests/")]
    return {
        other: [
            number
            for number, text in enumerate((project / other).read_text(encoding="utf-8").splitlines(), 1)
            if pattern.search(text)
        ]
        for other in [file, *others]
    }


def nearest_tests(project: Path, file: str) -> list[str]:
    """Return files of tests, nearest first: of that name, importing it, beside those, two imports away."""
    module, stem = "handcart." + file.removesuffix(".py").replace("/", "."), Path(file).stem
    importers = _importers(project)
    direct = {item for item in importers.get(module, ()) if item.startswith("tests/")}
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

    tests = {item for item in direct | beside | far if Path(item).name.startswith("test_")}
    return sorted(tests, key=lambda test: (nearness(test), test))


def _shared(file: str, test: str) -> int:
    """Return how many folders a file and a file of tests share."""
    own, other = Path(file).parent.parts, Path(test.split("::")[0]).parent.parts[1:]
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
