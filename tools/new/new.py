"""`handcart new`: a folder to begin from, which works as it is."""

from __future__ import annotations

from pathlib import Path
from string import Template
from typing import Annotated

import typer

KIND_NAMES = "project, task, objects, robot, primitive, domain or backend"


def new(
    kind: Annotated[str, typer.Argument(help=KIND_NAMES)],
    name: Annotated[str, typer.Argument(help="small letters, words joined by _")],
    out: Annotated[Path | None, typer.Option("--out", "-o", help="folder (default: NAME)")] = None,
) -> None:
    """Create the folder of a new project from templates, with its files and tests, and print the commands to
    try it.
    """
    from handcart.files.suggest import suggest
    from handcart.tools.commands.make_map import make_map

    from .scaffold import KINDS, names_of, write_new

    if kind not in KINDS:
        raise typer.BadParameter(f"unknown kind {kind!r}{suggest(kind, KINDS)}; allowed: {', '.join(KINDS)}")
    chosen, folder = KINDS[kind], out or Path(name)
    written = write_new(chosen, name, folder)
    for world in chosen.worlds:
        make_map(folder / world, (folder / world).with_name("map.yaml"))
    for path in written:
        print(path)
    print("\nNext:")
    for command in chosen.next_commands:
        print(f"  {Template(command).substitute(names_of(name), folder=folder)}")
