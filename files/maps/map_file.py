"""A map's file: a YAML file in ROS format (map_server) beside a picture, or a `.map` of MovingAI."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NamedTuple

from pydantic import AfterValidator, ConfigDict, Field

from handcart.files.errors import FileError, Finding, UnsafePath
from handcart.files.inside import portable, resolve_inside
from handcart.files.models.loading import Loaded, load_document
from handcart.files.models.model import FileModel
from handcart.files.picture import Grey, read_grey
from handcart.files.suggest import nearest
from handcart.files.yaml.yaml_document import Document, read_document
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.maps.grid_map import (
    GridMap,
    Mode,
    from_occupancy,
    ros_occupancy,
    unknown_read_as_free,
)
from handcart.robotics.navigation.maps.turned_map import TooManyCells, is_level, turned_occupancy
from handcart.robotics.numerics.arrays import Int8Array

from .movingai_map import MOVINGAI_SUFFIX, read_movingai

if TYPE_CHECKING:
    from collections.abc import Iterator

Metres = Annotated[float, Field(ge=-1e7, le=1e7)]  # grid coordinates on the Earth are as large
Share = Annotated[float, Field(ge=0.0, le=1.0)]
MOVINGAI_CELL_M = 1.0  # of a MovingAI map, whose file has no resolution


def _place(text: str) -> str:
    return text if text.startswith("/") and "\0" not in text else portable(text)


MapPlace = Annotated[str, AfterValidator(_place)]
"""Path of a map or picture as a file states it, relative on every system or absolute; still to be
resolved.
"""


class MapFile(FileModel):
    """Content of a map's YAML file in ROS format (map_server): picture, resolution, origin and thresholds.

    Unknown keys, which other programs add, are ignored.
    """

    model_config = ConfigDict(extra="ignore")

    image: MapPlace
    """Picture (PGM, PNG, BMP, JPEG, TIFF, WebP), or a MovingAI map.

    It is in the file's own folder or below, or given by its absolute path.
    """
    resolution: Annotated[float, Field(ge=1e-3, le=100.0)]
    """Side of a cell, in [m]."""
    origin: tuple[Metres, Metres, float]
    """x, y of the map's lower-left corner in [m], and turn of the map counter-clockwise in [rad]."""
    negate: Annotated[int, Field(ge=0, le=1)] | bool = 0
    """1 if dark cells are free."""
    occupied_thresh: Share = 0.65
    """Occupancy above which a cell is occupied."""
    free_thresh: Share = 0.25
    """Up to this occupancy a cell is free."""
    mode: Mode = "trinary"
    """Meaning of the grey levels; between the thresholds `scale` has percents. For driving, 100 is a wall and
    0 is free.
    """


class OccupancyFile(NamedTuple):
    """Occupancy values of a map file, with their resolution and origin."""

    values: Int8Array
    """(h, w) in percent, -1 for unknown, row 0 at the bottom."""
    resolution: float
    """Side of a cell, in [m]."""
    origin: tuple[float, float]
    """x, y of the lower-left corner in the map's frame, in [m]."""
    warning: str | None

    @property
    def grid(self) -> GridMap:
        """Occupancy grid of the map, in which each cell is occupied, free or unknown."""
        return from_occupancy(self.values, self.resolution, self.origin)


def is_map(document: Document) -> bool:
    """Return whether a file has the keys of a map in ROS format.

    One of the keys may be missing or misspelled, so that a map with such a mistake is still reported as a
    map.
    """
    keys = document.data.keys() if isinstance(document.data, dict) else set()
    return "format" not in keys and len({"image", "resolution", "origin"} & keys) >= 2


def is_map_file(path: Path) -> bool:
    """Return whether a file is a map; raise `FileError` if it cannot be read."""
    return path.suffix == MOVINGAI_SUFFIX or is_map(read_document(path))


def map_path(root: Path, name: str, *, start: Path) -> Path:
    """Return the path of a map that another file names.

    Maps made with ROS are often in another folder, so the absolute path of an existing map is allowed too.

    Args:
        root: folder that must contain a map with a relative path.
        name: path of the map in the other file.
        start: folder inside `root` that a relative path starts from.

    Raises:
        UnsafePath: a relative path leads out of `root`, or an absolute one is not that of a map.
    """
    if name.startswith("/"):
        with suppress(FileError):
            if is_map_file(Path(name)):
                return Path(name)
    return resolve_inside(root, name, start=start)


def load_map(path: Path) -> tuple[GridMap, str | None]:
    """Return the occupancy grid of a map file, and a warning about the file (None: no warning).

    Raises:
        FileError: the file or its picture is missing or wrong.
    """
    read = read_occupancy(path)
    grid = read.grid
    return grid, "\n".join(filter(None, [read.warning, _nothing_free(path, grid)])) or None


def _nothing_free(path: Path, grid: GridMap) -> str | None:
    """Return a warning about a map on which nothing can drive; None if a cell is free."""
    occupied, unknown = int(grid.occupied.sum()), int(grid.unknown.sum())
    if occupied + unknown < grid.occupied.size:
        return None
    words = f"no cell is free: {occupied} occupied, {unknown} unknown; check free_thresh, negate and mode"
    return str(Finding(str(path), 1, 1, f"{words}, and the picture's transparency (it counts as unknown)"))


def read_occupancy(path: Path) -> OccupancyFile:
    """Read a map file and its picture; raise `FileError` with every finding."""
    if path.suffix == MOVINGAI_SUFFIX:
        warning = f"a MovingAI map does not state the size of its cells; {MOVINGAI_CELL_M:g} m is assumed; "
        advice = f"to set it: a map's file with `image: {path.name}` and `resolution`"
        finding = str(Finding(str(path), 1, 1, warning + advice))
        return OccupancyFile(read_movingai(path), MOVINGAI_CELL_M, (0.0, 0.0), finding)
    loaded = load_document(read_document(path), MapFile)
    spec = loaded.value
    if wrong := list(_wrong(loaded)):
        raise FileError(wrong)
    picture = _picture_path(loaded, path)
    if picture.suffix == MOVINGAI_SUFFIX:
        return _placed(loaded, read_movingai(picture), None)
    grey = read_grey(picture)
    values = ros_occupancy(
        grey.level, spec.mode, spec.occupied_thresh, spec.free_thresh, bool(spec.negate), grey.opaque
    )
    return _placed(loaded, values, _warning(loaded, grey))


def _placed(loaded: Loaded[MapFile], values: Int8Array, warning: str | None) -> OccupancyFile:
    """Return the occupancy in the map's frame; a turned map is resampled along the axes of that frame.

    Args:
        loaded: the map's file.
        values: (h, w) occupancy in percent, -1 for unknown, row 0 at the bottom.
        warning: warning about the picture; None without one.

    Raises:
        FileError: the turned map has too many cells.
    """
    spec = loaded.value
    x, y, yaw = spec.origin
    if is_level(values.shape, yaw):
        return OccupancyFile(values, spec.resolution, (x, y), warning)
    try:
        turned = turned_occupancy(values, spec.resolution, Pose2(x, y, yaw))
    except TooManyCells as error:
        raise loaded.refuse(("origin", 2), str(error)) from None
    said = f"the map is turned by {yaw:.6g} rad: its cells are resampled along x and y, to half a cell"
    words = str(loaded.finding(("origin", 2), said))
    return OccupancyFile(
        turned.values, spec.resolution, turned.origin, "\n".join(filter(None, [warning, words]))
    )


def _wrong(loaded: Loaded[MapFile]) -> Iterator[Finding]:
    spec, keys = loaded.value, MapFile.model_fields
    for key in loaded.document.data:
        if key not in keys and (meant := nearest(key, keys)):
            yield loaded.finding((key,), f"unknown key {key!r}; did you mean {meant!r}?", at_key=True)
    if spec.free_thresh >= spec.occupied_thresh:
        wrong = (
            f"free_thresh is {spec.free_thresh}; allowed: less than occupied_thresh, {spec.occupied_thresh}"
        )
        yield loaded.finding(("free_thresh",), wrong)


def _picture_path(loaded: Loaded[MapFile], path: Path) -> Path:
    image = loaded.value.image
    try:
        picture = Path(image) if image.startswith("/") else _beside(path, image)
    except UnsafePath as unsafe:
        raise loaded.refuse(("image",), f"{unsafe}, or an absolute one") from None
    if not picture.is_file():
        raise loaded.refuse(("image",), f"no picture can be read from {image!r}; allowed: a picture's file")
    return picture


def _beside(path: Path, image: str) -> Path:
    """Return the path of the picture in the folder of the map file.

    If the map file is a link (as in ROS packages), the folder of its target counts as well.
    """
    try:
        return resolve_inside(path.parent, image)
    except UnsafePath:
        if not path.is_symlink():
            raise
        return resolve_inside(path.resolve().parent, image)


def _warning(loaded: Loaded[MapFile], grey: Grey) -> str | None:
    spec = loaded.value
    lost = 0
    if spec.mode == "trinary":
        lost = unknown_read_as_free(grey.level, spec.free_thresh, bool(spec.negate))
    if not lost:
        return None
    known = "free_thresh" in spec.model_fields_set
    line, column = loaded.document.position(("free_thresh",)) if known else (1, 1)
    warning = f"free_thresh {spec.free_thresh} turns {lost} unknown cells (grey 205) into free ones; "
    return str(Finding(loaded.document.file, line, column, warning + "use 0.196 to keep them unknown"))
