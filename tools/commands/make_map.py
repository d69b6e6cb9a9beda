"""`handcart make-map`: the map of a simulated world, in ROS format."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

HEIGHT_M = 0.2  # of most lidars on a cart
RESOLUTION_M = 0.02


def make_map(
    world: Annotated[Path, typer.Argument(help="a world's file")],
    out: Annotated[Path, typer.Option("--out", help="the map's file; its picture is written beside it")],
    height: Annotated[
        float, typer.Option(min=0.0, max=10.0, help="of the lidar above the floor, in m")
    ] = HEIGHT_M,
    resolution: Annotated[
        float, typer.Option(min=0.001, max=1.0, help="side of a cell, in m")
    ] = RESOLUTION_M,
) -> None:
    """Write the map of a simulated world as a lidar at one height would survey it.

    Things that are declared as surprises of the world are left out.
    """
    import numpy as np

    from handcart.backends.simulation.world_files.load_world import load_world
    from handcart.backends.simulation.world_files.world_map import map_of_world
    from handcart.evaluation.viewing.drawing.picture_file import write_png
    from handcart.files.yaml.yaml_word import yaml_word
    from handcart.tools.terminal.writing import NotWritable, check_folder, write_text

    if out.suffix != ".yaml":
        raise typer.BadParameter(f"{out} is not a map's file; allowed: a name that ends in .yaml")
    check_folder(out.parent)
    if out.resolve() == world.resolve():
        raise NotWritable(out, "it is the world's file", "another file")
    grid = map_of_world(load_world(world), height, resolution)
    out.parent.mkdir(parents=True, exist_ok=True)
    write_png(out.with_suffix(".png"), np.where(grid.occupied, 0, 254).astype(np.uint8)[::-1])
    write_text(
        out,
        f"image: {yaml_word(out.stem + '.png')}\nresolution: {resolution:g}\n"
        f"origin: [{grid.origin_x:g}, {grid.origin_y:g}, 0.0]\n"
        "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n",
    )
    rows, columns = grid.occupied.shape
    print(f"{out}: {columns * resolution:.1f} x {rows * resolution:.1f} m at a height of {height:g} m")
