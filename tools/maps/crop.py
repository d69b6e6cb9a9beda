"""`handcart map crop`: part of a map."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def crop(
    map_file: Annotated[Path, typer.Argument(metavar="MAP", help="a map's file")],
    output: Annotated[Path, typer.Option("-o", "--output", help="the new map's file, .yaml")],
    box: Annotated[
        str | None,
        typer.Option(help="LEFT,LOW,RIGHT,HIGH in m on the map (default: all that is known)"),
    ] = None,
) -> None:
    """Write the part of a map within a rectangle, or the map without its unknown edges; the frame stays the
    same.
    """
    from handcart.robotics.navigation.mapping.map_editing import NothingLeft, crop_to, crop_to_known

    from .map_words import numbers, read_map, save_map

    grid = read_map(map_file)
    try:
        if box is None:
            part = crop_to_known(grid)
        else:
            left, low, right, high = numbers(box, "--box", 4)
            part = crop_to(grid, (left, low), (right, high))
    except NothingLeft as error:
        raise typer.BadParameter(str(error)) from None
    save_map(output, part, map_file)
