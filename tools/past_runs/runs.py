"""`handcart runs`: the runs of a folder, the newest first."""

from __future__ import annotations

from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from handcart.networks.run_files.run_names import ListedRun


def runs(
    folder: Annotated[Path, typer.Argument(help="where the runs' folders are")] = Path("runs"),
    as_json: Annotated[bool, typer.Option("--json", help="one JSON list on stdout")] = False,
) -> None:
    """Print a list of runs with folder, task, seed, backend, outcome and start time."""
    import orjson

    from handcart.files.printable import printable
    from handcart.networks.run_files.run_names import list_runs

    found = list_runs(folder)
    if as_json:
        rows = [{**vars(run), "folder": str(run.folder)} for run in found]
        print(orjson.dumps(rows, option=orjson.OPT_INDENT_2).decode())
        return
    if not found:
        print(printable(f"no runs in {folder}; `handcart run TASK` makes one"))
        return
    head = ("run", "task", "seed", "backend", "outcome", "begun")
    table = [head, *(_row(run) for run in found)]
    widths = [max(map(len, column)) for column in zip(*table, strict=True)]
    for row in table:
        print("  ".join(word.ljust(width) for word, width in zip(row, widths, strict=True)).rstrip())


def _row(run: ListedRun) -> tuple[str, ...]:
    from handcart.files.printable import printable

    when = datetime.fromtimestamp(run.begun).strftime("%Y-%m-%d %H:%M:%S")
    ended = run.outcome or "no end"
    return tuple(map(printable, (str(run.folder), run.task, str(run.seed), run.backend, ended, when)))
