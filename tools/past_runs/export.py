"""`handcart export`: what was recorded, in a format of other programs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def export(
    folder: Annotated[Path, typer.Argument(help="a campaign's folder")],
    file: Annotated[Path, typer.Option("--output", "-o", help="*.parquet: a row each trial")],
) -> None:
    """Write the trials of a campaign as Parquet."""
    from handcart.evaluation.campaigns.campaign_folder import CampaignFolder
    from handcart.evaluation.export.campaign_parquet import write_parquet
    from handcart.files.printable import printable
    from handcart.tools.terminal.writing import NotWritable

    if file.suffix != ".parquet":
        raise NotWritable(file, f"nothing is written with the suffix {file.suffix!r}", "*.parquet")
    trials = CampaignFolder.read(folder).trials()
    try:
        write_parquet(trials, file)
    except OSError as error:
        raise NotWritable(file, error.strerror) from None
    print(printable(f"written: {file}, {len(trials)} trials"))
