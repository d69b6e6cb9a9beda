"""A map's file, in ROS format (map_server): a YAML file beside a picture."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import cv2
import numpy as np
from pydantic import Field

from files.errors import FileError, Finding
from files.inside import FilePath
from files.loading import load_document
from files.model import FileModel
from files.yaml_document import Document, read_document
from robotics.navigation.grid_map import GridMap, from_ros, unknown_read_as_free

Positive = Annotated[float, Field(gt=0.0)]


class MapFile(FileModel):
    """A map in ROS format (map_server), trinary."""

    image: FilePath
    resolution: Positive
    origin: tuple[float, float, float]
    negate: Annotated[int, Field(ge=0, le=1)] = 0
    occupied_thresh: Annotated[float, Field(gt=0.0, lt=1.0)] = 0.65
    free_thresh: Annotated[float, Field(gt=0.0, lt=1.0)] = 0.25
    mode: Literal["trinary"] = "trinary"


def is_map(document: Document) -> bool:
    """Whether a file says of itself that it is a map in ROS format."""
    keys = document.data.keys() if isinstance(document.data, dict) else set()
    return "format" not in keys and {"image", "resolution", "origin"} <= keys


def load_map(path: Path) -> tuple[GridMap, str | None]:
    """A map in ROS format, and a warning about it, if there is one.

    Raises:
        FileError: the YAML or its image is missing or wrong.
    """
    loaded = load_document(read_document(path), MapFile)
    spec = loaded.value
    picture = path.parent / spec.image
    image = cv2.imread(str(picture), cv2.IMREAD_GRAYSCALE) if picture.is_file() else None
    if image is None:
        raise FileError([loaded.finding(("image",), f"no picture can be read from {spec.image!r}")])
    if spec.origin[2] != 0.0:
        raise loaded.refuse(("origin", 2), f"the map is turned by {spec.origin[2]} rad; allowed: 0")
    negate = bool(spec.negate)
    grid = from_ros(
        image.astype(np.uint8),
        spec.resolution,
        spec.origin[:2],
        spec.occupied_thresh,
        spec.free_thresh,
        negate,
    )
    lost = unknown_read_as_free(image.astype(np.uint8), spec.free_thresh, negate)
    if not lost:
        return grid, None
    warning = f"free_thresh {spec.free_thresh} turns {lost} unknown cells (grey 205) into free ones; "
    line, column = (
        loaded.document.position(("free_thresh",)) if "free_thresh" in spec.model_fields_set else (1, 1)
    )
    return grid, str(Finding(str(path), line, column, warning + "use 0.196 to keep them unknown"))
