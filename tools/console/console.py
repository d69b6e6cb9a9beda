"""`handcart console`: the operator's page in the browser."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def console(
    runs: Annotated[Path, typer.Argument(help="where the runs' folders are")] = Path("runs"),
    port: Annotated[
        int | None,
        typer.Option(min=0, max=65535, help="port (default: 8090 or the next free one)"),
    ] = None,
    host: Annotated[
        str | None,
        typer.Option(help="address to listen at, instead of this machine alone; the token permits commands"),
    ] = None,
) -> None:
    """Serve the console, a web page that shows and controls all runs, until Ctrl-C.

    The runs do not depend on the console.
    """
    from handcart.files.extras import lack
    from handcart.files.printable import printable
    from handcart.tools.terminal.asked_to_end import AskedToEnd

    wrong = lack("the console", "console")
    if wrong is not None:
        from handcart.files.errors import InputError

        raise InputError(wrong)
    from .server import Server

    over = AskedToEnd()
    server = Server(runs, host, port)
    print(printable(f"runs in {runs}: {server.address}"), flush=True)
    print("the address holds the token, which permits commands; Ctrl-C ends the page, and no run", flush=True)
    server.serve(lambda: bool(over))
    raise typer.Exit(over.status)
