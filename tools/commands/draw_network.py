"""`handcart draw`: a task's action network as a picture."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def draw(
    task: Annotated[Path, typer.Argument(help="a task's file, or its name (`handcart list tasks`)")],
    output: Annotated[Path, typer.Option("-o", "--output", help="FILE.svg, .png, .pdf, .mmd or .dot")],
) -> None:
    """Draw a task's action network: as SVG, PNG, PDF, Mermaid or dot, by the file's ending."""
    from handcart.files.suggest import suggest
    from handcart.networks.drawing.drawing import WRITER_BY_SUFFIX
    from handcart.networks.task.task_file import load_task
    from handcart.tasks.task_names import task_path
    from handcart.tools.terminal.writing import write_text

    if output.suffix not in WRITER_BY_SUFFIX:
        raise typer.BadParameter(
            f"unknown suffix {output.suffix!r} of a drawing{suggest(output.suffix, WRITER_BY_SUFFIX)}"
        )
    loaded = load_task(task_path(task))
    write_text(output, WRITER_BY_SUFFIX[output.suffix](loaded.network, loaded.file.title))
    print(f"drawn into {output}")
