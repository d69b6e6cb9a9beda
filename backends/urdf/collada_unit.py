"""The unit of length that a COLLADA file declares."""

from __future__ import annotations

import math
from pathlib import Path
from xml.parsers import expat

COLLADA_SUFFIX = ".dae"
HEAD_BYTES = 65536
"""The `<asset>` element, which declares the unit, comes first in a file."""


class _Found(Exception):
    """The search for the unit can end, because it was read, or the `<asset>` element has ended."""


def collada_unit_m(path: Path) -> float:
    """Return the length of a mesh file's unit in [m]; 1 if it declares none, or is not a COLLADA file.

    As in RViz, MoveIt and Gazebo the unit is applied and the up axis is not, because URDFs are written for
    these tools. MeshLab, for example, writes `Y_UP` into each file, whatever the axes of its coordinates
    are.

    Raises:
        ValueError: the unit is not a positive length.
    """
    if path.suffix.lower() != COLLADA_SUFFIX:
        return 1.0
    stated = _stated_unit(path)
    if stated is None:
        return 1.0
    try:
        metres = float(stated)
    except ValueError:
        metres = math.nan
    if not math.isfinite(metres) or metres <= 0.0:
        raise ValueError(f"its unit is {stated[:40]!r} m; allowed: a number above 0")
    return metres


def _stated_unit(path: Path) -> str | None:
    """Return the attribute `meter` of `<asset><unit>`, or None."""
    found: list[str] = []

    def start(tag: str, attributes: dict[str, str]) -> None:
        if tag.rpartition(":")[2] == "unit" and "meter" in attributes:
            found.append(attributes["meter"])
            raise _Found

    def end(tag: str) -> None:
        if tag.rpartition(":")[2] == "asset":
            raise _Found

    parser = expat.ParserCreate()
    parser.StartElementHandler, parser.EndElementHandler = start, end
    try:
        with path.open("rb") as file:
            parser.Parse(file.read(HEAD_BYTES), False)
    except _Found:
        pass  # the parser is stopped by this: the rest of the file, often megabytes, says nothing of the unit
    except (expat.ExpatError, OSError):
        return None  # reported with its cause where the mesh itself is read
    return found[0] if found else None
