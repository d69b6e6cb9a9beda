"""A map in place of a world's file."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

import cv2
import numpy as np

from handcart.files.maps.map_file import is_map_file, load_map
from handcart.robotics.geometry.pose2 import Pose2, wrap
from handcart.robotics.navigation.maps.grid_map import UNKNOWN_GREY, GridMap


@contextmanager
def as_world_file(path: Path, start: Pose2) -> Iterator[Path]:
    """Yield the path of a world's file, which is created temporarily if `path` is a map.

    The temporary world contains all occupied cells of the map, and the robot at `start` (world_T_base); its
    file is deleted at the end of the context. Backends that read world files themselves use this function;
    see `Backend.read_world`.

    Raises:
        FileError: the file, or the picture of a map, cannot be read.
    """
    if not is_map_file(path):
        yield path
        return
    grid, _ = load_map(path)
    with TemporaryDirectory(prefix="handcart-") as folder:
        yield _write(Path(folder), grid, start)


def _write(folder: Path, grid: GridMap, start: Pose2) -> Path:
    grey = np.where(grid.occupied, 0, np.where(grid.unknown, UNKNOWN_GREY, 254)).astype(np.uint8)
    cv2.imwrite(str(folder / "map.png"), grey[::-1])
    (folder / "map.yaml").write_text(
        f"image: map.png\nresolution: {grid.resolution}\norigin: [{grid.origin_x}, {grid.origin_y}, 0.0]\n"
        "occupied_thresh: 0.65\nfree_thresh: 0.196\n",
        encoding="utf-8",
    )
    world = folder / "world.yaml"
    world.write_text(
        "format: handcart-world/1\nmap: map.yaml\n"
        f"start: {{x_m: {start.x}, y_m: {start.y}, heading_deg: {math.degrees(wrap(start.theta))}}}\n",
        encoding="utf-8",
    )
    return world
