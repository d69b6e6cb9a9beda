"""`handcart report`: a run, or a campaign, as one page."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def report(
    folder: Annotated[
        Path | None, typer.Argument(help="a run's folder, or a campaign's (default: runs/latest)")
    ] = None,
    page: Annotated[
        Path | None, typer.Option("--output", "-o", help="*.html (default: report.html in the folder)")
    ] = None,
) -> None:
    """Write the report on a run or a campaign as a single HTML file, which needs no other files and no
    network.
    """
    from handcart.evaluation.campaigns.data.campaign_folder import ARGUMENTS
    from handcart.files.printable import printable
    from handcart.networks.run_files.run_names import latest_run
    from handcart.tools.terminal.writing import NotWritable

    folder = folder or latest_run(Path("runs"))
    if page is not None and page.suffix != ".html":
        raise NotWritable(page, f"unknown suffix {page.suffix!r} of a page", "*.html")
    try:
        write = _campaign_page if (folder / ARGUMENTS).exists() else _run_page
        print(printable(f"written: {write(folder, page)}"))
    except OSError as error:
        raise NotWritable(page or folder, error.strerror) from None


def _run_page(folder: Path, page: Path | None) -> Path:
    from handcart.evaluation.viewing.report.report import write_report

    return write_report(folder, page)


def _campaign_page(folder: Path, page: Path | None) -> Path:
    from handcart.evaluation.campaigns.page.campaign_page import CampaignPage
    from handcart.tools.terminal.skipped_trial import note_skipped

    found = CampaignPage.of(folder)
    note_skipped(folder, found.skipped_bytes)
    found.write_runs()
    return found.write(page)
