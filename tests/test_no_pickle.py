"""Nothing in the tree makes objects from bytes by their names: what comes from a folder or a wire is data.

Process pools (`concurrent.futures`) pickle between a process and its own children, never from a folder.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
ROOMS = (
    "backends",
    "benchmarks",
    "evaluation",
    "files",
    "networks",
    "primitives",
    "robotics",
    "scripts",
    "src",
    "tasks",
)
FORBIDDEN = {"pickle", "_pickle", "cPickle", "marshal", "shelve", "dill", "cloudpickle", "joblib", "copyreg"}


def wrong(source: str) -> Iterator[str]:
    if source.isascii() and not any(name in source for name in (*FORBIDDEN, "allow_pickle")):
        return  # nothing to parse for: of other letters, the parser may read some as ASCII
    for node in ast.walk(ast.parse(source)):
        names = []
        if isinstance(node, ast.Import):
            names = [item.name for item in node.names]
        elif isinstance(node, ast.ImportFrom):
            names = [node.module or ""]
        yield from (name for name in names if name.split(".")[0] in FORBIDDEN)
        if isinstance(node, ast.keyword) and node.arg == "allow_pickle":
            yield from [] if ast.unparse(node.value) == "False" else ["allow_pickle"]
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name | ast.Attribute):
            called = node.func.id if isinstance(node.func, ast.Name) else node.func.attr
            arguments = [arg.value for arg in node.args if isinstance(arg, ast.Constant)]
            if called in ("__import__", "import_module") and FORBIDDEN & set(map(str, arguments)):
                yield called


@pytest.mark.parametrize("room", [*ROOMS, "tools", "tests"])
def test_no_room_imports_what_unpickles(room: str) -> None:
    found = {
        str(path.relative_to(ROOT)): names
        for path in (ROOT / room).rglob("*.py")
        if (names := list(wrong(path.read_text(encoding="utf-8"))))
    }
    assert found == {}


@pytest.mark.parametrize(
    "source",
    [
        "import pickle",
        "from pickle import loads",
        "import os, marshal as m",
        "import numpy as np\nnp.load('x', allow_pickle=True)",
        "from importlib import import_module\nimport_module('dill')",
        "import ｐｉｃｋｌｅ",
    ],
)
def test_the_test_sees_it(source: str) -> None:
    assert list(wrong(source))
