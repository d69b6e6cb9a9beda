"""`handcart describe`: what a primitive takes, needs and does."""

from __future__ import annotations

import inspect
from typing import Annotated

import typer


def describe(name: Annotated[str, typer.Argument(help="a primitive, such as MOVE_TO")]) -> None:
    """Tell what a primitive does, takes, needs, reads and writes."""
    from primitives.registry import primitive_class

    try:
        kind = primitive_class(name)
    except KeyError as unknown:
        raise typer.BadParameter(str(unknown.args[0])) from None
    print(f"{name}\n\n{inspect.cleandoc(kind.__doc__ or '')}\n")
    for key, field in kind.model_fields.items():
        default = "required" if field.is_required() else f"default {field.default!r}"
        what = getattr(field.annotation, "__name__", field.annotation)
        print(f"  {key} ({what}, {default}): {field.description}")
    print(f"\nneeds:  {', '.join(each.__name__ for each in kind.needs) or 'nothing'}")
    print(f"reads:  {', '.join(kind.reads) or 'nothing'}")
    print(f"writes: {', '.join(kind.writes) or 'nothing'}")
