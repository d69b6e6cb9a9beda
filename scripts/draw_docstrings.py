"""Draw public docstrings by a seed and print them without their code, to be read by a stranger.

Two questions are asked of what is printed. Of any docstring: is it understood without the code? Of a
function that takes or returns arrays (`--arrays`): are shape, unit, frame and errors stated?
"""

from __future__ import annotations

import argparse
import ast
import random
import re
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

REPOSITORY_ROOT = Path(__file__).resolve().parents[1]
SOURCE_FOLDERS = ("backends", "evaluation", "files", "networks", "primitives", "robotics", "tasks", "tools")
ARRAY_PATTERN = re.compile(r"Array\b|NDArray|Transform\b|GreyImage")
Function = ast.FunctionDef | ast.AsyncFunctionDef
FUNCTION_NODES = (ast.FunctionDef, ast.AsyncFunctionDef)


class Documented(NamedTuple):
    """A public function, class or module with its docstring."""

    place: str
    """File and line."""
    title: str
    """Its name; of a function with its signature, as a reference page shows it."""
    text: str
    takes_arrays: bool
    """True for a function with an array among its parameters or returned."""


def documented(root: Path = REPOSITORY_ROOT) -> Iterator[Documented]:
    """Yield everything public with a docstring, in the order of files and lines."""
    for room in SOURCE_FOLDERS:
        for path in sorted((root / room).rglob("*.py")):
            place = path.relative_to(root).as_posix()
            tree = ast.parse(path.read_text(encoding="utf-8"))
            yield from _documented(tree, place, "")


def _documented(node: ast.Module | ast.ClassDef, place: str, owner: str) -> Iterator[Documented]:
    for child in node.body:
        if not isinstance(
            child, ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef
        ) or child.name.startswith("_"):
            continue
        title, takes_arrays = owner + child.name, False
        if isinstance(child, FUNCTION_NODES):
            takes_arrays = bool(ARRAY_PATTERN.search(_signature(child)))
            title = f"{title}{_signature(child)}"
        text = ast.get_docstring(child)
        if text:
            yield Documented(f"{place}:{child.lineno}", title, text, takes_arrays)
        if isinstance(child, ast.ClassDef):
            yield from _documented(child, place, f"{owner}{child.name}.")


def _signature(function: Function) -> str:
    returned = f" -> {ast.unparse(function.returns)}" if function.returns else ""
    return f"({ast.unparse(function.args)}){returned}"


def main() -> None:
    """Print the drawn docstrings."""
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    words.add_argument("--count", type=int, default=60, help="number of docstrings (default: %(default)s)")
    words.add_argument("--seed", type=int, default=0, help="seed of the draw (default: %(default)s)")
    words.add_argument("--arrays", action="store_true", help="only functions that take or return arrays")
    chosen = words.parse_args()
    every = [documented_ for documented_ in documented() if documented_.takes_arrays or not chosen.arrays]
    drawn = random.Random(chosen.seed).sample(every, min(chosen.count, len(every)))
    for number, item in enumerate(drawn, 1):
        print(f"{number}. {item.place}  {item.title}\n    {item.text.replace(chr(10), chr(10) + '    ')}\n")
    print(f"{len(drawn)} of {len(every)}, seed {chosen.seed}")


if __name__ == "__main__":
    main()
