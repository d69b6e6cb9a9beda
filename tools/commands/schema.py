"""`handcart schema`: JSON Schemas for editors."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def schema(
    kind: Annotated[str, typer.Argument(help="such as task, robot, world, places")],
    output: Annotated[Path | None, typer.Option("-o", "--output", help="a file instead of stdout")] = None,
) -> None:
    """Print the JSON Schema of a kind of file."""
    import json

    from handcart.files.models import json_schema
    from handcart.files.suggest import suggest
    from handcart.tools.checks.file_kinds import kinds, model_of
    from handcart.tools.terminal.writing import write_text

    if kind not in kinds():
        raise typer.BadParameter(f"unknown kind of file {kind!r}{suggest(kind, kinds())}")
    text = json.dumps(json_schema.schema(model_of(kind)), indent=2)
    if output is None:
        print(text)
    else:
        write_text(output, text + "\n")
