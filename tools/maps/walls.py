"""`handcart map walls`: a map held against the walls of a world's file."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated

import typer

HEIGHT_M = 0.2
MAX_SHOWN_THINGS = 20


def walls(
    map_file: Annotated[Path, typer.Argument(metavar="MAP", help="a map's file")],
    world: Annotated[Path, typer.Argument(help="a world's file")],
    height: Annotated[
        float, typer.Option(min=0.0, max=10.0, help="of the lidar above the floor, in m")
    ] = HEIGHT_M,
    align: Annotated[
        bool, typer.Option("--align", help="move the world to where it fits (default: one frame for both)")
    ] = False,
    as_json: Annotated[bool, typer.Option("--json", help="one JSON object on stdout")] = False,
) -> None:
    """Print how far the walls of a map are from those of a simulated world, and which of these the map
    lacks.
    """
    import numpy as np
    import orjson

    from handcart.backends.simulation.world_files.load_world import load_world
    from handcart.backends.simulation.world_files.world_map import map_of_world, shown_solids
    from handcart.robotics.geometry.pose2 import Pose2
    from handcart.robotics.navigation.mapping.box_walls import compare_with_boxes
    from handcart.robotics.navigation.mapping.map_comparison import compare_maps
    from handcart.tools.terminal.first_use import announced

    from .map_words import read_map

    grid, known = read_map(map_file), load_world(world)
    if not grid.occupied.any():
        raise typer.BadParameter(f"{map_file} has no occupied cell; needed: a map with walls")
    drawn = map_of_world(known, height, grid.resolution)
    solids = shown_solids(known, height)
    with announced("comparing"):
        pose = compare_maps(grid, drawn).first_T_second if align else Pose2(0.0, 0.0, 0.0)
        found = compare_with_boxes(grid, [solid.outline for solid in solids], pose)
    median, high = float(np.median(found.cells)), float(np.quantile(found.cells, 0.95))
    rows = zip((solid.box.name for solid in solids), found.missing, found.visible, strict=True)
    lacking = sorted(((share, name, length) for name, share, length in rows if share > 0.0), reverse=True)
    if as_json:
        shown = [{"name": name, "missing": share, "visible_m": length} for share, name, length in lacking]
        content = {
            "x_m": pose.x,
            "y_m": pose.y,
            "heading_deg": math.degrees(pose.theta),
            "median_m": median,
            "p95_m": high,
            "lacking": shown,
        }
        print(orjson.dumps(content).decode())
        return
    if align:
        at = f"x {pose.x:.3f} m, y {pose.y:.3f} m, {math.degrees(pose.theta):.2f} deg"
        print(f"the frame of {world.name} is at {at} in that of {map_file.name}")
    print(
        f"walls of {map_file.name}: median {100 * median:.1f} cm, 95 % {100 * high:.1f} cm from the world's"
    )
    for share, name, length in lacking[:MAX_SHOWN_THINGS]:
        print(f"{name}: {100 * share:.0f} % of {length:.1f} m of its visible outline is not on the map")
    if len(lacking) > MAX_SHOWN_THINGS:
        print(f"and {len(lacking) - MAX_SHOWN_THINGS} more, see --json")
