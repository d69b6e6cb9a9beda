"""`handcart map keepout`: zones that routes keep out of."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def keepout(
    map_file: Annotated[Path, typer.Argument(metavar="MAP", help="a map's file")],
    output: Annotated[
        Path, typer.Option("-o", "--output", help="the zones' file, .yaml; changed if it exists")
    ],
    add: Annotated[
        list[str] | None, typer.Option(help="X,Y,X,Y,X,Y,... in m: corners of a zone; may be repeated")
    ] = None,
    remove: Annotated[
        list[str] | None, typer.Option(help="the same: zones within these corners are taken away")
    ] = None,
) -> None:
    """Write a file of keep-out zones for a map, into which the robot must not drive.

    A task uses the file if its own file has the entry `knowledge: {keepout: FILE}`.
    """
    import numpy as np

    from handcart.robotics.navigation.mapping.map_editing import paint_zone

    from .map_words import numbers, read_map, save_map

    if not add and not remove:
        raise typer.BadParameter("nothing to do; allowed: --add or --remove with the corners of a zone")
    grid = read_map(map_file)
    nothing = np.zeros(grid.occupied.shape, dtype=np.bool_)
    zones = read_map(output) if output.exists() else grid._replace(occupied=nothing, unknown=nothing)
    for option, texts, is_barred in (("--add", add or [], True), ("--remove", remove or [], False)):
        for text in texts:
            values = numbers(text, option)
            corners = list(zip(values[::2], values[1::2], strict=True))
            changed = paint_zone(zones, corners, is_barred)
            if (changed.occupied == zones.occupied).all():
                raise typer.BadParameter(f"{option} {text}: no cell changes; allowed: corners on the map")
            zones = changed
    save_map(output, zones, map_file)
    share = float(zones.occupied.sum()) * zones.resolution**2
    print(f"zones cover {share:.2f} m2")
