"""`handcart map turn`: a map turned in its frame."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated

import typer


def turn(
    map_file: Annotated[Path, typer.Argument(metavar="MAP", help="a map's file")],
    output: Annotated[Path, typer.Option("-o", "--output", help="the new map's file, .yaml")],
    deg: Annotated[
        float | None,
        typer.Option(
            min=-360.0, max=360.0, help="counter-clockwise (default: until walls lie along x and y)"
        ),
    ] = None,
) -> None:
    """Write a map turned about the origin of its frame.

    Places that are given on the map have to be turned by the same angle.
    """
    from handcart.robotics.navigation.mapping.map_editing import straightening_angle
    from handcart.robotics.navigation.mapping.map_editing import turn as turned
    from handcart.robotics.navigation.maps.turned_map import TooManyCells

    from .map_words import read_map, save_map

    grid = read_map(map_file)
    angle = straightening_angle(grid) if deg is None else math.radians(deg)
    try:
        found = turned(grid, angle)
    except TooManyCells as error:
        raise typer.BadParameter(str(error)) from None
    print(f"turned by {math.degrees(angle):.2f} deg")
    save_map(output, found, map_file)
