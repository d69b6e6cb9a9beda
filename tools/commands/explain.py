"""`handcart explain`: why a run went as it did."""

from __future__ import annotations

import math
import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from handcart.evaluation.viewing.explanation.explanation import Explanation


def explain(
    run: Annotated[Path | None, typer.Argument(help="the run's folder (default: runs/latest)")] = None,
    action: Annotated[
        int | None, typer.Option(help="number of the action (default: the last that failed, or the run)")
    ] = None,
    picture: Annotated[
        Path | None, typer.Option(help="file for the chart (default: in the run's folder)")
    ] = None,
    frames: Annotated[
        Path | None,
        typer.Option(
            help="a log that another recorder wrote meanwhile (.asc, .blf, .csv, .db, .log, .trc) "
            "(default: the run's own frames)"
        ),
    ] = None,
    at: Annotated[
        float | None, typer.Option(help="time in that log, in s of its stamps (default: its end)")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="one JSON object on stdout")] = False,
) -> None:
    """Print why a run chose an action, why the action failed, and whether it restored the state before it.

    If the action failed, each thing that it moved is listed with the distance from its place before the
    action.
    """
    import orjson

    from handcart.evaluation.viewing.explanation.explanation import as_json as json_of
    from handcart.evaluation.viewing.explanation.explanation import explain as explained
    from handcart.evaluation.viewing.explanation.explanation_chart import UnreadableEvidence
    from handcart.evaluation.viewing.explanation.explanation_words import in_words
    from handcart.files.printable import printable
    from handcart.networks.past_runs.past_run import read_run
    from handcart.networks.run_files.run_names import latest_run

    if at is not None and frames is None:
        raise typer.BadParameter("--at without --frames; needed: the log whose time it is")
    past = read_run(run or latest_run(Path("runs")))
    if past.torn_at is not None:
        _warn(f"the journal's tail is torn at byte {past.torn_at}: later records are unknown")
    explanation = explained(past, action)
    if frames is not None:
        explanation = replace(explanation, frames=frames, frames_at=math.inf if at is None else at)
    chart, damaged = None, None
    try:
        chart = _drawn(explanation, picture)
    except UnreadableEvidence as error:
        damaged = error
    if as_json:
        print(orjson.dumps(json_of(explanation, chart), option=orjson.OPT_INDENT_2).decode())
    else:
        print("\n".join(printable(line) for line in in_words(explanation, chart).splitlines()))
    if damaged is not None:
        raise damaged


def _drawn(explanation: Explanation, picture: Path | None) -> Path | None:
    """Draw the chart and return its path; None if there is nothing to draw, or no space."""
    from handcart.evaluation.viewing.explanation.explanation_chart import draw_chart
    from handcart.tools.terminal.writing import NotWritable

    if not (explanation.readings or explanation.picture or explanation.points):
        if picture is not None:
            _warn("no readings or pictures were kept of this: nothing is drawn")
        return None
    name = f"explained_{explanation.action.number:03d}.svg" if explanation.action else "explained.svg"
    path = picture or explanation.run.folder / name
    if path.suffix not in (".svg", ".png", ".pdf"):
        raise NotWritable(path, f"unknown suffix {path.suffix!r} of a picture", "*.svg, *.png or *.pdf")
    try:
        draw_chart(explanation, path)
    except OSError as error:
        if picture is not None:
            raise NotWritable(path, error.strerror) from None
        _warn(f"{path} can't be written: {error.strerror}; allowed: another place, --picture FILE.svg")
        return None
    return path


def _warn(words: str) -> None:
    print(f"warning: {words}", file=sys.stderr)
