"""The packages come from this checkout, and what documents show exists."""

from __future__ import annotations

import ast
import importlib
import os
import re
import subprocess
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import NamedTuple

import networkx
import pytest

ROOT = Path(__file__).resolve().parents[1]


ROOMS = ("robotics", "files", "backends", "primitives", "networks", "evaluation", "tasks", "tools")


def python(code: str, where: Path, **more: str) -> str:
    """Return the output of a program that is run in another folder."""
    command = [sys.executable, "-c", code]
    ended = subprocess.run(
        command, cwd=where, env=os.environ | more, capture_output=True, text=True, check=False
    )
    assert ended.returncode == 0, ended.stderr
    return ended.stdout


@pytest.mark.parametrize("room", ROOMS)
def test_each_room_is_this_checkouts(room: str) -> None:
    link = ROOT / "src" / "handcart" / room
    assert link.is_symlink()
    assert link.readlink() == Path("../..") / room
    assert Path(str(importlib.import_module(f"handcart.{room}").__file__)) == ROOT / room / "__init__.py"


def test_no_room_can_be_imported_by_a_name_of_its_own(tmp_path: Path) -> None:
    code = f"from importlib.util import find_spec; print([room for room in {ROOMS!r} if find_spec(room)])"
    assert python(code, tmp_path) == "[]\n"
    code = f"""
for room in {ROOMS!r}:
    try:
        __import__(room)
    except ImportError as error:
        assert f"import handcart.{{room}}" in str(error), error
    else:
        print(room)
"""
    assert python(code, ROOT) == ""


def test_nothing_imports_a_bare_room() -> None:
    listed = [
        path for room in (*ROOMS, "tests", "benchmarks", "scripts") for path in (ROOT / room).rglob("*.py")
    ]
    bare = re.compile(rf"^\s*(?:from|import\s[^\n]*?)\s*(?<![.\w])(?:{'|'.join(ROOMS)})\b", re.MULTILINE)
    doubted = [path for path in listed if bare.search(path.read_text(encoding="utf-8"))]
    found = [
        f"{path}: {name}" for path in doubted for name in _facts(path).imported if name.split(".")[0] in ROOMS
    ]
    assert found == []


def test_there_are_no_circles() -> None:
    """Of modules that import each other, late ones, named ones and those for types alone counted."""
    graph = networkx.DiGraph()
    modules = {".".join(_parts(path)): path for room in ROOMS for path in (ROOT / room).rglob("*.py")}
    for module, path in modules.items():
        for name in _named(path):
            while name and name not in modules:
                name = name.rpartition(".")[0]
            if name and name != module:
                graph.add_edge(module, name)
    assert graph.number_of_edges() > 2000
    assert [
        sorted(component) for component in networkx.strongly_connected_components(graph) if len(component) > 1
    ] == []


class Facts(NamedTuple):
    """What tests ask of a file, without its syntax tree: the trees of all files take half a gigabyte."""

    imported: tuple[str, ...]
    """Modules that are imported by their whole names."""
    imports: tuple[tuple[int, str | None, tuple[str, ...]], ...]
    """Of each import the level, the module and the names after `import`."""
    texts: tuple[str, ...]
    """Strings that begin like a module of ours."""
    functions: tuple[tuple[str, int, int], ...]
    """Name, line and lines of each body, without the docstring."""
    classes: tuple[str, ...]


@cache
def _facts(path: Path) -> Facts:
    nodes = list(ast.walk(ast.parse(path.read_text(encoding="utf-8"))))
    plain = [name.name for node in nodes if isinstance(node, ast.Import) for name in node.names]
    froms = [node for node in nodes if isinstance(node, ast.ImportFrom)]
    functions = [node for node in nodes if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)]
    return Facts(
        (*plain, *(node.module or "" for node in froms if not node.level)),
        (
            *((0, None, (name,)) for name in plain),
            *((node.level, node.module, tuple(name.name for name in node.names)) for node in froms),
        ),
        tuple(
            str(node.value)
            for node in nodes
            if isinstance(node, ast.Constant) and str(node.value).startswith("handcart.")
        ),
        tuple((node.name, node.lineno, _body_lines(node)) for node in functions),
        tuple(node.name for node in nodes if isinstance(node, ast.ClassDef)),
    )


def _parts(path: Path) -> list[str]:
    parts = ["handcart", *path.relative_to(ROOT).with_suffix("").parts]
    return parts[:-1] if parts[-1] == "__init__" else parts


def _named(path: Path) -> Iterator[str]:
    """Everything in a file that may name a module of ours."""
    yield from _imported_modules(path)
    yield from (text.replace(":", ".") for text in _facts(path).texts)


_ROOMS = "contract outcomes restoring knowledge motions driving"
_EVALUATION = "campaigns trials judging viewing robot_report bringup"
GENERAL = (
    "networks",
    *(f"primitives/{room}" for room in _ROOMS.split()),
    "backends",
    *(f"evaluation/{room}" for room in _EVALUATION.split()),
    *(f"evaluation/conformance/{room}" for room in ("rig", "checks", "faults", "planted")),
    "files",
    "tools",
)
OWN_ROOMS = ("books", "blocks", "field", "seam", "calibration", "objects", "doors")
WORDS = r"\bbooks?\b|shel(f|ves)\b|\bblocks?\b|magazine|\bspine|\bseam|landmark|\btargets\b"
OTHER_WORDS = (
    'style="display:block">',
    "block end>",
    ".spines[",
    ".landmarks.",
    "finally` blocks",
    "may lead out of it, block,",
    "goal, targets",
    "targets: ",
)
SHELVED = ROOT / "primitives" / "knowledge" / "place.py"  # its file always had the key `shelf`


@pytest.mark.parametrize("room", GENERAL)
def test_general_rooms_name_no_domain(room: str) -> None:
    """Domains have rooms of their own."""
    named = [
        f"{path.relative_to(ROOT)}:{number}: {line.strip()}"
        for path in sorted((ROOT / room).rglob("*.py"))
        if path.parent.name not in OWN_ROOMS and path != SHELVED
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), start=1)
        if re.search(WORDS, line, re.IGNORECASE) and not any(words in line for words in OTHER_WORDS)
    ]
    assert named == []


def test_folders_do_not_import_each_other_in_circles() -> None:
    """A folder is a concept: those that it builds on know nothing of it, imports for types counted."""
    graph = networkx.DiGraph()
    folder_of = {}
    for path in (path for room in ROOMS for path in (ROOT / room).rglob("*.py")):
        folder_of[".".join(_parts(path))] = str(path.parent.relative_to(ROOT))
    for path in (path for room in ROOMS for path in (ROOT / room).rglob("*.py")):
        own = str(path.parent.relative_to(ROOT))
        for name in _imported_modules(path):
            while name and name not in folder_of:
                name = name.rpartition(".")[0]
            if name and folder_of[name] != own:
                graph.add_edge(own, folder_of[name])
    assert graph.number_of_edges() > 300
    assert [
        sorted(component) for component in networkx.strongly_connected_components(graph) if len(component) > 1
    ] == []


def _imported_modules(path: Path) -> Iterator[str]:
    """Everything that a file names after `import`, with its whole name."""
    here = _parts(path) if path.name == "__init__.py" else _parts(path)[:-1]
    for level, module, names in _facts(path).imports:
        above = here[: len(here) - level + 1] if level else []
        base = ".".join([*above, *filter(None, [module])])
        yield from (f"{base}.{name}" if base else name for name in names)


def test_tests_mirror_the_rooms() -> None:
    rooms = [ROOT / room for room in (*ROOMS, "benchmarks")]
    strangers = [
        str(path.relative_to(ROOT))
        for room in rooms
        for path in (ROOT / "tests" / room.name).rglob("test_*.py")
        if room.name != "tasks" and not (ROOT / path.parent.relative_to(ROOT / "tests")).is_dir()
    ]
    assert strangers == []


KERNELS = ": bound_table:"  # a loop over a grid whose parts share some twenty numbers
CODE = (*ROOMS, "benchmarks", "scripts")


def test_files_have_at_most_400_lines() -> None:
    paths = [path for room in CODE for path in (ROOT / room).rglob("*.py")]
    lengths = {path: len(path.read_text(encoding="utf-8").splitlines()) for path in paths}
    assert len(lengths) > 1000
    assert [f"{path}: {length}" for path, length in lengths.items() if length > 400] == []


def test_functions_have_at_most_50_lines() -> None:
    """Without the signature and the docstring; compiled kernels of one loop are longer."""
    bodies = [
        (f"{path.relative_to(ROOT)}:{line}: {name}", lines)
        for room in CODE
        for path in (ROOT / room).rglob("*.py")
        for name, line, lines in _facts(path).functions
    ]
    assert len(bodies) > 5000
    long = [f"{place}: {lines}" for place, lines in bodies if lines > 50]
    assert [item for item in long if not re.search(KERNELS, item)] == []


def _body_lines(node: ast.FunctionDef | ast.AsyncFunctionDef) -> int:
    statements = node.body if ast.get_docstring(node) is None else node.body[1:]
    return (statements[-1].end_lineno or 0) - statements[0].lineno + 1 if statements else 0


def test_array_types_are_named_in_one_module() -> None:
    paths = [path for room in (*CODE, "tests") for path in (ROOT / room).rglob("*.py")]
    named = [
        f"{path.relative_to(ROOT)}: {alias}"
        for path in paths
        if "outside" not in path.parts
        for alias in re.findall(
            r"^\w+ = (?:npt\.)?NDArray\[.*$", path.read_text(encoding="utf-8"), re.MULTILINE
        )
    ]
    assert len(named) > 5
    assert [item for item in named if not item.startswith("robotics/numerics/arrays.py")] == []


def test_names_of_tests_have_at_most_65_characters() -> None:
    paths = (ROOT / "tests").rglob("*.py")
    names = [name for path in paths for name, _, _ in _facts(path).functions if name.startswith("test_")]
    assert [name for name in names if len(name) > 65] == []


def test_class_names_mean_one_thing() -> None:
    names = [
        name
        for room in ROOMS
        for path in (ROOT / room).rglob("*.py")
        for name in _facts(path).classes
        if not name.startswith("_")
    ]
    assert sorted({name for name in names if names.count(name) > 1}) == []
