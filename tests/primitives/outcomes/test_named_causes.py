"""Every place that raises a Discrepancy or NeedsPerson names a cause from a declared set."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path

import pytest

from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.cause_kind import CauseKind

ROOT = Path(__file__).resolve().parents[3]
ROOMS = ("primitives", "networks", "evaluation", "backends", "tasks", "tools", "examples", "benchmarks")
RAISED = {"Discrepancy", "NeedsPerson"}
FILES = [path for room in ROOMS for path in sorted((ROOT / room).rglob("*.py"))]
RAISING = {
    path: text for path in FILES if any(f"{item}(" in (text := path.read_text("utf-8")) for item in RAISED)
}
CAUSE_MODULES = [path for path in FILES if path.name == "causes.py" or path.name.endswith("_causes.py")]


def raising(tree: ast.AST) -> Iterator[ast.Call]:
    """Calls of the two classes, by their own name or as an attribute."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Call):
            name = getattr(node.func, "id", getattr(node.func, "attr", ""))
            if name in RAISED:
                yield node


def lacking(text: str) -> list[int]:
    """Lines that raise without a cause that is a constant, of another module or of their own."""
    lines = []
    for call in raising(ast.parse(text)):
        cause = next((keyword.value for keyword in call.keywords if keyword.arg == "cause"), None)
        name = getattr(cause, "attr", getattr(cause, "id", ""))
        constant = name.isupper() and name != "UNNAMED"
        derived = isinstance(cause, ast.Call)  # of a function that selects one
        if not constant and not derived:
            lines.append(call.lineno)
    return lines


def test_every_discrepancy_names_a_cause() -> None:
    found = [f"{path.relative_to(ROOT)}:{line}" for path, text in RAISING.items() for line in lacking(text)]
    assert sum(text.count("cause=") for text in RAISING.values()) > 120
    assert found == []


@pytest.mark.parametrize(
    "text",
    [
        'raise Discrepancy("it resists")',
        'raise NeedsPerson("it squeaks", check="push")',
        'raise outcomes.Discrepancy("it resists", True)',
        'raise Discrepancy("it resists", cause=causes.UNNAMED)',
        'raise Discrepancy("it resists", cause=why)',
    ],
)
def test_a_place_without_a_cause_is_found(text: str) -> None:
    assert lacking(text) == [1]


def declared() -> dict[str, CauseKind]:
    """All constants of the modules that declare causes, by module and name."""
    found: dict[str, CauseKind] = {}
    for path in CAUSE_MODULES:
        module = import_module("handcart." + ".".join(path.relative_to(ROOT).with_suffix("").parts))
        kinds = {name: value for name, value in vars(module).items() if isinstance(value, CauseKind)}
        found |= {f"{path.stem}.{name}": kind for name, kind in kinds.items()}
    return found


def test_causes_have_names_of_their_own() -> None:
    kinds = declared()
    assert len({kind.name for kind in kinds.values()}) == len(kinds)
    assert all(path.rpartition(".")[2] == kind.name.upper() for path, kind in kinds.items())
    assert all(kind.text[0].isupper() and kind.text.endswith(".") for kind in kinds.values())


def test_every_declared_cause_is_used() -> None:
    rooms = ("primitives", "networks")
    texts = "".join(path.read_text("utf-8") for room in rooms for path in (ROOT / room).rglob("*.py"))
    unused = [path for path in declared() if path not in texts and path != "causes.UNNAMED"]
    assert unused == []


def test_outside_causes_are_those_of_supervision() -> None:
    from handcart.networks.coordination import supervision

    text = Path(supervision.__file__).read_text("utf-8")
    named = {getattr(causes, call.keywords[-1].value.attr) for call in raising(ast.parse(text))}  # type: ignore[attr-defined]
    assert named <= set(causes.OUTSIDE_CAUSES)
