"""`handcart export`: a recorded run in a format of other programs."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Annotated

import typer

from handcart.files.printable import counted


def export(
    folder: Annotated[Path, typer.Argument(help="a run's folder, or a campaign's; with --to: a task")],
    file: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="*.mcap: a run; *.parquet: a campaign, a row each trial"),
    ] = None,
    to: Annotated[
        str | None, typer.Option("--to", help="format of a task: bt (BehaviorTree.CPP), scxml, jani")
    ] = None,
) -> None:
    """Convert a run to MCAP, the trials of a campaign to Parquet, or a task to another format.

    Formats of tasks are a behaviour tree, a state chart (SCXML) and a model for model checkers (JANI).
    """
    from handcart.files.printable import printable
    from handcart.tools.terminal.writing import NotWritable

    if to is not None:
        _task(folder, to, file)
        return
    if file is None:
        raise typer.BadParameter("needed: -o FILE, or --to FORMAT for a task")
    write = EXPORT_BY_SUFFIX.get(file.suffix)
    if write is None:
        raise NotWritable(file, f"unknown suffix {file.suffix!r} of an export", "*.mcap, *.parquet")
    try:
        words = write(folder, file)
    except OSError as error:
        raise NotWritable(file, error.strerror) from None
    print(printable(f"written: {file}, {words}"))


def _task(path: Path, to: str, file: Path | None) -> None:
    """Write a task in a format of other programs.

    Args:
        path: the task's file.
        to: name of the format: bt, scxml or jani.
        file: file to write; None: stdout.
    """
    import sys

    from handcart.evaluation.interchange.exporting import FORMAT_WRITERS, exported
    from handcart.files.printable import printable
    from handcart.files.suggest import suggest
    from handcart.networks.task.task_file import load_task
    from handcart.tasks.task_names import task_path
    from handcart.tools.terminal.writing import write_text

    if to not in FORMAT_WRITERS:
        raise typer.BadParameter(f"unknown format {to!r}{suggest(to, FORMAT_WRITERS)}")
    text, lost = exported(load_task(task_path(path)), to)
    for item in lost:
        print(printable(f"{path}: kept, but not carried out: {item}"), file=sys.stderr)
    if file is None:
        print(text, end="")
    else:
        write_text(file, text)
        print(printable(f"written: {file}"))


def _mcap(folder: Path, file: Path) -> str:
    from handcart.evaluation.viewing.export.run_mcap import write_mcap
    from handcart.evaluation.viewing.playback.playback import Playback

    counts = write_mcap(Playback.read(folder), file)
    return ", ".join(f"{count} {topic}" for topic, count in sorted(counts.items()))


def _parquet(folder: Path, file: Path) -> str:
    from handcart.evaluation.campaigns.data.campaign_folder import CampaignFolder
    from handcart.evaluation.viewing.export.campaign_parquet import write_parquet
    from handcart.tools.terminal.skipped_trial import with_note

    trials = with_note(CampaignFolder.read(folder).trials(), folder)
    write_parquet(trials, file)
    return counted(len(trials), "trial")


EXPORT_BY_SUFFIX: Mapping[str, Callable[[Path, Path], str]] = {".mcap": _mcap, ".parquet": _parquet}
"""Writers of recorded runs, by file suffix."""
