"""Mutants drawn by a seed: a module in turn, a file by its length, a place, one of the mutations there."""

from __future__ import annotations

import ast
import difflib
import random
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from call_remover import CallRemover
from cosmic_ray.ast import ast_nodes, get_ast
from cosmic_ray.mutating import mutate_code
from cosmic_ray.operators.operator import Operator
from cosmic_ray.operators.provider import OperatorProvider

MODULE_GROUPS: Mapping[str, Sequence[str]] = {
    "contract": ["primitives/contract"],
    "restoring": ["primitives/restoring"],
    "coordination": ["networks/coordination"],
    "journal": ["networks/journal"],
    "runs": ["networks/runs"],
    "operator": ["networks/operator"],
    "robot": ["backends/robot"],
    "localization": ["robotics/navigation/localization", "backends/robot/localization"],
    "outdoors": ["robotics/navigation/outdoors"],
    "can": ["backends/can"],
    "campaigns": ["evaluation/campaigns"],
    "console": ["tools/console"],
}
"""Folders of each module that mutants are drawn from."""
COMPARISON_OPERATORS = ("Lt", "LtE", "Gt", "GtE", "Eq", "NotEq")
ARITHMETIC_OPERATORS = ("Add", "Sub", "Mul", "Div")
OPERATOR_NAMES = (
    *(
        f"ReplaceComparisonOperator_{a}_{b}"
        for a in COMPARISON_OPERATORS
        for b in COMPARISON_OPERATORS
        if a != b
    ),
    *("ReplaceComparisonOperator_Is_IsNot", "ReplaceComparisonOperator_IsNot_Is"),
    *(f"ReplaceBinaryOperator_{a}_{b}" for a in ARITHMETIC_OPERATORS for b in ARITHMETIC_OPERATORS if a != b),
    *("ReplaceUnaryOperator_USub_UAdd", "ReplaceUnaryOperator_Delete_Not", "AddNot"),
    *("ReplaceTrueWithFalse", "ReplaceFalseWithTrue", "ReplaceAndWithOr", "ReplaceOrWithAnd"),
    *("ReplaceBreakWithContinue", "ReplaceContinueWithBreak", "ZeroIterationForLoop"),
    *("ExceptionReplacer", "NumberReplacer"),
)
"""Cosmic Ray's operators, without those whose mutants hardly any test could miss: `a | b` of two floats, a
removed decorator, a name exchanged for another one."""
MAX_TRIES = 1000


@dataclass(frozen=True)
class DrawnMutant:
    """One change to one file; has the attributes that `Bed` reads."""

    file: str
    """Path in the project."""
    line: int
    content: str
    """Text of the file with the change."""
    name: str
    """Changed lines: `-old` and `+new`."""
    before: str
    """Changed lines as they are, joined, without indentation."""
    after: str
    """Changed lines as they become."""
    module: str
    tests: tuple[str, ...] = ()

    def planted(self, sound: str) -> str:
        """Return the file's content with the change."""
        return self.content if self.content != sound else ""


def operators() -> list[Operator]:
    """Return one of each kind of mutation that is drawn."""
    provider = OperatorProvider()
    return [*(provider[name]() for name in OPERATOR_NAMES), CallRemover()]


def draw(project: Path, seed: str, modules: Sequence[str]) -> Iterator[DrawnMutant]:
    """Yield mutants without end, no two alike, modules in turn in an order that the seed gives."""
    rng, drawn = random.Random(seed), set[tuple[str, str]]()
    for _ in range(MAX_TRIES):
        for module in rng.sample(list(modules), len(modules)):
            mutant = _draw_one(project, module, rng)
            if mutant is not None and (mutant.file, mutant.content) not in drawn:
                drawn.add((mutant.file, mutant.content))
                yield mutant


def _draw_one(project: Path, module: str, rng: random.Random) -> DrawnMutant | None:
    """Return a mutant; None where the drawn change can't act: in an annotation, or not valid Python."""
    files = _files(project, module)
    (path,) = rng.choices(files, [path.stat().st_size for path in files])
    source = path.read_text(encoding="utf-8")
    places = _places(source)
    if not places:
        return None
    kinds = places[rng.choice(sorted(places))]
    number, occurrence = rng.choice(kinds)
    try:
        content = mutate_code(source, operators()[number], occurrence)
    except AttributeError:  # Cosmic Ray 8.7 can't replace an exception with a dot in its name
        return None
    if content is None or not differs(source, content):
        return None
    return mutant_of(path.relative_to(project).as_posix(), source, content, module)


@cache
def _files(project: Path, module: str) -> list[Path]:
    nested = [folder for folders in MODULE_GROUPS.values() for folder in folders]
    found = set()
    for folder in MODULE_GROUPS[module]:
        inner = [project / item for item in nested if item.startswith(f"{folder}/")]
        for path in (project / folder).rglob("*.py"):
            if not any(item in path.parents for item in inner):
                found.add(path)
    return sorted(found)


@cache
def _places(source: str) -> dict[tuple[int, int], list[tuple[int, int]]]:
    """Return, for each place in a source, the operators' numbers and occurrences that change it."""
    places: dict[tuple[int, int], list[tuple[int, int]]] = {}
    nodes = list(ast_nodes(get_ast(source)))
    for number, operator in enumerate(operators()):
        positions = (start for node in nodes for start, _ in operator.mutation_positions(node))
        for occurrence, start in enumerate(positions):
            places.setdefault(start, []).append((number, occurrence))
    return places


def mutant_of(file: str, source: str, content: str, module: str = "") -> DrawnMutant:
    """Describe the change from one text of a file to another."""
    old, new = source.splitlines(), content.splitlines()
    lines = list(difflib.unified_diff(old, new, lineterm="", n=0))[2:]
    shown = [line for line in lines if not line.startswith("@@")]
    before = " ".join(line[1:].strip() for line in shown if line.startswith("-"))
    after = " ".join(line[1:].strip() for line in shown if line.startswith("+"))
    first = next(number for number, (a, b) in enumerate(zip(old, [*new, *old], strict=False), 1) if a != b)
    return DrawnMutant(file, first, content, "\n".join(shown), before, after, module)


def differs(source: str, content: str) -> bool:
    """Return whether a change is valid Python that can act: one of annotations alone is never evaluated."""
    try:
        return _acting(source) != _acting(content)
    except (SyntaxError, ValueError):
        return False


def _acting(source: str) -> str:
    """Dump the syntax tree without the annotations."""
    tree = ast.parse(source)
    for node in ast.walk(tree):
        for name in ("annotation", "returns"):
            if hasattr(node, name):
                setattr(node, name, None)
    return ast.dump(tree)
