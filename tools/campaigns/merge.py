"""`handcart campaign merge`: the parts of a campaign that ran on many machines, as one."""

from __future__ import annotations

import sys
import tempfile
from contextlib import ExitStack
from pathlib import Path
from typing import Annotated

import typer


def merge(
    parts: Annotated[list[Path], typer.Argument(help="folders of the parts, each made with another --shard")],
    out: Annotated[Path | None, typer.Option(help="keep the whole campaign in this folder")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="end with one JSON object on stdout")] = False,
) -> None:
    """Merge the parts of a campaign, and print the same report as for a campaign run on one machine."""
    import orjson

    from handcart.evaluation.campaigns.data.merging import merged
    from handcart.evaluation.campaigns.page.campaign_page import CampaignPage
    from handcart.files.printable import printable
    from handcart.tools.terminal.campaign_words import report_of

    with ExitStack() as stack:
        folder = out or Path(stack.enter_context(tempfile.TemporaryDirectory())) / "whole"
        whole = merged(parts, folder)
        report, words = report_of(whole)
        print(orjson.dumps(words.facts()).decode() if as_json else "\n".join(words.lines()))
        if out is not None and not whole.arguments.get("rare"):
            page = CampaignPage(whole, report, None)
            page.write_runs()
            print(printable(f"written: {page.write()}"), file=sys.stderr)
        sys.exit(5 if report.faulty else 0)
