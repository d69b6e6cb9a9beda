"""`handcart describe`: a primitive's parameters, needs and steps, or the simulation of a backend."""

from __future__ import annotations

import inspect
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from handcart.primitives.contract.action_primitive import ActionPrimitive


def describe(name: Annotated[str, typer.Argument(help="a primitive, such as MOVE_TO, or a backend")]) -> None:
    """Describe a primitive's effect, parameters, needs and facts, or a backend's limits."""
    from handcart.backends.registry import backend_class, backend_names
    from handcart.primitives.registry import primitive_class

    if name in backend_names():
        print(f"{name}\n\n{inspect.getdoc(backend_class(name))}")
        return
    try:
        kind = primitive_class(name)
    except KeyError as unknown:
        raise typer.BadParameter(str(unknown.args[0])) from None
    print(f"{name}\n\n{inspect.getdoc(kind)}\n")
    print("\n".join(_parameters(kind)) or "  no parameters")
    print(f"\nneeds:  {', '.join(need.__name__ for need in kind.needs) or 'nothing'}")
    print(f"reads:  {', '.join(kind.reads) or 'nothing'}")
    print(f"writes: {', '.join(kind.writes) or 'nothing'}")
    print("\n".join(_causes(kind)))
    if tree := _tree(kind):
        print(f"\n{tree}")


def _causes(kind: type[ActionPrimitive]) -> list[str]:
    """Return a primitive's own causes of Fails and GiveUps, with texts, and the names of common causes."""
    from handcart.primitives.contract.raised_causes import causes_of, framework_causes

    own = causes_of(kind)
    lines = [f"  {cause.name}: {cause.text}" for cause in own]
    every = ", ".join(
        framework_cause.name for framework_cause in framework_causes() if framework_cause not in own
    )
    return ["\ncauses of Fails and GiveUps:", *lines, f"  as of any primitive: {every}"]


def _parameters(kind: type[ActionPrimitive]) -> list[str]:
    from handcart.files.models.field_docstrings import field_docstrings
    from handcart.files.models.schema_walk import SchemaWalk
    from handcart.files.models.schema_words import described, shown

    walk = SchemaWalk(kind.__pydantic_core_schema__)
    lines, docstrings = [], field_docstrings(kind)
    for key, field in kind.model_fields.items():
        default = "required" if field.is_required() else f"default {shown(field.default)}"
        text = field.description or docstrings.get(key, "")
        description = f": {text}" if text else ""
        lines.append(f"  {key} ({described(walk, walk.place((key,)).schema, key)}; {default}){description}")
    return lines


def _tree(kind: type[ActionPrimitive]) -> str:
    """Return a primitive's behaviour tree, with default parameters, as text; empty if it cannot be shown."""
    from py_trees.display import ascii_tree

    from handcart.primitives.contract.tree_primitive import TreePrimitive

    if not issubclass(kind, TreePrimitive):
        return ""
    nobody: Any = None
    try:
        return ascii_tree(kind.model_construct().tree(nobody, nobody)).rstrip()
    except Exception:  # a user's tree that asks robot, model or a required parameter while it is built
        return ""
