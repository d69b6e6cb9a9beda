"""Docstrings below the fields of a model, read from its source on request."""

from __future__ import annotations

import ast
import inspect
import textwrap
from functools import cache

from pydantic import BaseModel


def field_docstrings(model: type[BaseModel]) -> dict[str, str]:
    """Return the docstring below each field, by the field's name; fields without one are left out.

    Pydantic's own option (`use_attribute_docstrings`) would slow down imports, because it reads the source of
    each model during its import.
    """
    found: dict[str, str] = {}
    for part in reversed(model.__mro__):
        if issubclass(part, BaseModel):
            own = _own(part)
            found = {name: text for name, text in found.items() if name not in part.__annotations__} | own
    return {name: text for name, text in found.items() if name in model.model_fields}


@cache
def _own(model: type[BaseModel]) -> dict[str, str]:
    try:
        source = textwrap.dedent(inspect.getsource(model))
    except (OSError, TypeError):  # made by a program, without a source
        return {}
    [definition] = ast.parse(source).body
    assert isinstance(definition, ast.ClassDef)
    pairs = zip(definition.body, definition.body[1:], strict=False)
    return {
        field.target.id: inspect.cleandoc(below.value.value)
        for field, below in pairs
        if isinstance(field, ast.AnnAssign)
        and isinstance(field.target, ast.Name)
        and isinstance(below, ast.Expr)
        and isinstance(below.value, ast.Constant)
        and isinstance(below.value.value, str)
    }
