"""`handcart report`: a run as one page."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def report(
    run: Annotated[Path | None, typer.Argument(help="the run's folder; left out: runs/latest")] = None,
    page: Annotated[
        Path | None, typer.Option("--output", "-o", help="*.html; left out: report.html in the run's folder")
    ] = None,
) -> None:
    """Write a run as one page that needs nothing beside it, nor a network."""
    from handcart.evaluation.report.report import write_report
    from handcart.files.printable import printable
    from handcart.networks.runs.run_names import latest_run
    from handcart.tools.terminal.writing import NotWritable

    folder = run or latest_run(Path("runs"))
    if page is not None and page.suffix != ".html":
        raise NotWritable(page, f"no page has the suffix {page.suffix!r}", "*.html")
    try:
        print(printable(f"written: {write_report(folder, page)}"))
    except OSError as error:
        raise NotWritable(page or folder, error.strerror) from None
