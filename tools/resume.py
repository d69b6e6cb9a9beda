"""`handcart resume` and `handcart ack`: go on with a run that broke off."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated, Literal

import typer

Permit = Literal["ask", "always", "never"]
RunFolder = Annotated[Path, typer.Argument(help="the run's folder")]


def resume(
    run: RunFolder,
    confirm: Annotated[
        int | None,
        typer.Option(help="RECORD: the last one that you have seen; needed where a real robot moves"),
    ] = None,
    permit: Annotated[Permit, typer.Option(help="actions with `permit: operator`")] = "ask",
    as_json: Annotated[bool, typer.Option("--json", help="end with one JSON object on stdout")] = False,
) -> None:
    """Tell what is known, expected and unknown of a run that broke off, then go on with it."""
    import orjson

    from evaluation.running import resume_task
    from networks.permits import Permits

    from .progress import Progress

    permits = Permits(permit)
    with Progress() as progress:
        permits.asking, permits.typed = progress.ask, progress.typed
        summary, status = resume_task(run, confirm, progress, permits)
    if as_json:
        print(orjson.dumps(summary).decode())
    else:
        reason = f": {summary['reason']}" if summary["reason"] else ""
        print(f"{summary['outcome']} in situation {summary['situation']}{reason}; see {run}")
    sys.exit(status)


def ack(
    run: RunFolder,
    record: Annotated[int, typer.Argument(help="the record of the GiveUp, as `resume` tells it")],
) -> None:
    """Acknowledge a GiveUp: everything is as it was before that action, and the run may go on."""
    from networks.acknowledging import acknowledge

    reason = acknowledge(run, record)
    print(f"acknowledged: {reason}; handcart resume {run} goes on")
