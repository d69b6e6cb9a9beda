"""`handcart map compare`: two maps of one place."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from handcart.robotics.navigation.mapping.map_comparison import MapComparison

PICTURE_SUFFIXES = (".svg", ".png", ".pdf")


def compare(
    first: Annotated[Path, typer.Argument(metavar="MAP", help="a map's file")],
    second: Annotated[Path, typer.Argument(metavar="OTHER", help="another map's file")],
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="FILE.svg, .png or .pdf: both maps in one picture")
    ] = None,
    keep: Annotated[
        bool, typer.Option("--keep", help="both have one frame: do not align the other map")
    ] = False,
    as_json: Annotated[bool, typer.Option("--json", help="one JSON object on stdout")] = False,
) -> None:
    """Align a map with another one, and report how far apart their walls are."""
    from handcart.evaluation.mapping.comparison_picture import draw_comparison
    from handcart.robotics.geometry.pose2 import Pose2
    from handcart.robotics.navigation.mapping.map_comparison import compare_maps
    from handcart.tools.terminal.first_use import announced
    from handcart.tools.terminal.writing import NotWritable

    from .map_words import read_map

    if output is not None and output.suffix not in PICTURE_SUFFIXES:
        raise typer.BadParameter(
            f"unknown suffix {output.suffix!r} of a picture; allowed: {', '.join(PICTURE_SUFFIXES)}"
        )
    grids = read_map(first), read_map(second)
    for path, grid in zip((first, second), grids, strict=True):
        if not grid.occupied.any():
            raise typer.BadParameter(f"{path} has no occupied cell; needed: a map with walls")
    with announced("aligning the maps"):
        found = compare_maps(*grids, Pose2(0.0, 0.0, 0.0) if keep else None)
    names = distinct_names(first, second)
    report(found, *names, as_json)
    if output is not None:
        try:
            draw_comparison(grids, found.first_T_second, output, names)
        except OSError as error:
            raise NotWritable(output, error.strerror) from None


def distinct_names(first: Path, second: Path) -> tuple[str, str]:
    """Return the shortest ends of two paths that distinguish them, such as `office/map.yaml` and
    `other/map.yaml`.
    """
    one, other = first.resolve().parts, second.resolve().parts
    for count in range(1, max(len(one), len(other))):
        names = "/".join(one[-count:]), "/".join(other[-count:])
        if names[0] != names[1]:
            return names
    return str(first), f"{second} (the same file)"


def report(found: MapComparison, first: str, second: str, as_json: bool) -> None:
    """Print how far apart the walls of two maps are, as text or as JSON.

    Args:
        found: comparison of the maps.
        first: name of the first map in the text.
        second: name of the second map in the text.
        as_json: True for one JSON object.
    """
    import orjson

    pose, names = found.first_T_second, (first, second)
    rows = [found.figures(distances) for distances in (found.first, found.second)]
    if as_json:
        keys = ("median_m", "p95_m", "missing_in_other")
        shown = [
            dict(zip(keys, (None if math.isnan(value) else round(value, 5) for value in row), strict=True))
            for row in rows
        ]
        print(
            orjson.dumps(
                {"x_m": pose.x, "y_m": pose.y, "heading_deg": math.degrees(pose.theta), "walls": shown}
            ).decode()
        )
        return
    print(
        f"the frame of {second} is at x {pose.x:.3f} m, y {pose.y:.3f} m, "
        f"{math.degrees(pose.theta):.2f} deg in that of {first}"
    )
    for name, other, (median, high, missing) in zip(names, reversed(names), rows, strict=True):
        words = f"walls of {name}: "
        if math.isnan(missing):
            print(f"{words}not compared, {other} knows nothing at their places")
            continue
        if math.isnan(median):
            print(f"{words}none is in {other}")
            continue
        print(
            f"{words}median {100 * median:.1f} cm, 95 % {100 * high:.1f} cm from those of {other}; "
            f"{100 * missing:.1f} % are not there"
        )
