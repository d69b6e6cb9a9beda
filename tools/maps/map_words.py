"""Reading of numbers and maps that the map tools share."""

from __future__ import annotations

import math
import sys
from pathlib import Path

import typer

from handcart.files.csv_table import number_in
from handcart.files.maps.map_file import load_map
from handcart.files.maps.map_writing import write_grid
from handcart.robotics.navigation.maps.grid_map import GridMap
from handcart.tools.terminal.writing import NotWritable, check_folder

MAP_SUFFIX = ".yaml"


def read_map(path: Path) -> GridMap:
    """Return the map in a file; print the warning about the map to stderr, if there is one."""
    grid, warning = load_map(path)
    if warning:
        print(warning, file=sys.stderr)
    return grid


def save_map(path: Path, grid: GridMap, source: Path) -> None:
    """Write a map's YAML file and picture, and print its size.

    Args:
        path: file to write; its folder is made if it is missing.
        grid: the map.
        source: file that the map was read from, which must be another one.

    Raises:
        typer.BadParameter: the path has another suffix than a map's file.
        NotWritable: the folder cannot be made or written into, or it is the file that was read.
    """
    if path.suffix != MAP_SUFFIX:
        raise typer.BadParameter(f"{path} is not a map's file; allowed: a name that ends in {MAP_SUFFIX}")
    check_folder(path.parent)
    if path.resolve() == source.resolve():
        raise NotWritable(path, "it is the map that is read", "another file")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        write_grid(path, grid)
    except OSError as error:
        raise NotWritable(path, error.strerror) from None
    rows, columns = grid.occupied.shape
    across, up = columns * grid.resolution, rows * grid.resolution
    print(f"{path}: {across:.2f} x {up:.2f} m, corner at ({grid.origin_x:.3f}, {grid.origin_y:.3f})")


def numbers(text: str, option: str, count: int | None = None) -> list[float]:
    """Parse numbers separated by commas, in [m].

    Args:
        text: text given by the user.
        option: name of the option, used in messages.
        count: required number of values; None: any even number from six on.

    Raises:
        typer.BadParameter: the count is wrong, or a part is not a finite number.
    """
    found = [number_in(word.strip()) for word in text.split(",")]
    is_right = len(found) == count if count is not None else len(found) >= 6 and len(found) % 2 == 0
    if not is_right or not all(math.isfinite(value) and abs(value) < 1e7 for value in found):
        needed = f"{count} numbers" if count is not None else "x,y of at least three corners"
        raise typer.BadParameter(f"{option} {text!r}; allowed: {needed}, with commas between, in m")
    return found
