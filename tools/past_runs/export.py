"""`handcart export`: a recorded run in a format of other programs."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Annotated

import typer

from handcart.files.printable import counted


def export(
    folder: Annotated[Path, typer.Argument(help="a run's folder, or a campaign's")],
    file: Annotated[
        Path, typer.Option("--output", "-o", help="*.mcap: a run; *.parquet: a campaign, a row each trial")
    ],
) -> None:
    """Write a run as MCAP, or the trials of a campaign as Parquet."""
    from handcart.files.printable import printable
    from handcart.tools.terminal.writing import NotWritable

    write = EXPORT_BY_SUFFIX.get(file.suffix)
    if write is None:
        raise NotWritable(file, f"nothing is written with the suffix {file.suffix!r}", "*.mcap, *.parquet")
    try:
        words = write(folder, file)
    except OSError as error:
        raise NotWritable(file, error.strerror) from None
    print(printable(f"written: {file}, {words}"))


def _mcap(folder: Path, file: Path) -> str:
    from handcart.evaluation.viewing.export.run_mcap import write_mcap
    from handcart.evaluation.viewing.playback.playback import Playback

    counts = write_mcap(Playback.read(folder), file)
    return ", ".join(f"{count} {topic}" for topic, count in sorted(counts.items()))


def _parquet(folder: Path, file: Path) -> str:
    from handcart.evaluation.campaigns.data.campaign_folder import CampaignFolder
    from handcart.evaluation.viewing.export.campaign_parquet import write_parquet

    trials = CampaignFolder.read(folder).trials()
    write_parquet(trials, file)
    return counted(len(trials), "trial")


EXPORT_BY_SUFFIX: Mapping[str, Callable[[Path, Path], str]] = {".mcap": _mcap, ".parquet": _parquet}
"""Writers of recorded runs, by file suffix."""
