"""`handcart view`: a run in three dimensions in the browser."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def view(
    run: Annotated[Path | None, typer.Argument(help="the run's folder (default: runs/latest)")] = None,
    port: Annotated[
        int | None,
        typer.Option(min=0, max=65535, help="port (default: 8080 or the next free one)"),
    ] = None,
) -> None:
    """Show a recorded run in the browser, on this machine alone, until Ctrl-C."""
    from handcart.evaluation.viewing.playback.playback import Playback
    from handcart.evaluation.viewing.view.replay import Replay
    from handcart.evaluation.viewing.view.serving.server import open_server
    from handcart.files.printable import printable
    from handcart.networks.run_files.run_names import latest_run
    from handcart.tools.terminal.asked_to_end import AskedToEnd

    playback = Playback.read(run or latest_run(Path("runs")))
    over = AskedToEnd()
    with open_server(port, "handcart view") as opened:
        replay = Replay(opened.server, playback)
        print(printable(f"{playback.run.folder}: {opened.address} shows it; Ctrl-C ends that"), flush=True)
        replay.run(lambda: bool(over))
    raise typer.Exit(over.status)
