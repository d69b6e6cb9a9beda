"""Reading a `.map` of the MovingAI benchmarks (Sturtevant, 2012): https://movingai.com/benchmarks/formats.html."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from handcart.files.errors import FileError, Finding
from handcart.files.picture import MAX_PIXELS
from handcart.files.regular_file import decode_text, read_regular_file
from handcart.robotics.navigation.maps.grid_map import FREE_VALUE, OCCUPIED_VALUE, UNKNOWN_VALUE
from handcart.robotics.numerics.arrays import Int8Array

MOVINGAI_SUFFIX = ".map"
MAX_BYTES = MAX_PIXELS + (1 << 20)
_MEANING = {
    ".": FREE_VALUE,
    "G": FREE_VALUE,
    "S": FREE_VALUE,
    "@": OCCUPIED_VALUE,
    "O": OCCUPIED_VALUE,
    "T": OCCUPIED_VALUE,
    "W": UNKNOWN_VALUE,
}
"""Occupancy by terrain; @ and O are out of bounds. Water is impassable but not a wall, so it is unknown."""
_HEADER = (("type", r"type\s+octile"), ("height", r"height\s+(\d{1,6})"), ("width", r"width\s+(\d{1,6})"))


def read_movingai(path: Path) -> Int8Array:
    """Return the occupancy (h, w) of a Moving AI map in percent, -1 for water, row 0 at the bottom.

    The bottom is the last row of the file.

    Raises:
        FileError: the file cannot be read, or is not a Moving AI map; with the line of the fault.
    """
    file = str(path)
    lines = decode_text(read_regular_file(path, MAX_BYTES), file, longest_line=None).splitlines()
    height, width = _size(file, lines)
    rows = [line.rstrip() for line in lines[4 : 4 + height]]
    if len(rows) < height or any(line.strip() for line in lines[4 + height :]):
        raise _refused(
            file, min(len(lines), 4 + height), f"{len(lines) - 4} rows; allowed: the {height} stated"
        )
    table = np.full(128, -2, dtype=np.int8)
    table[[ord(item) for item in _MEANING]] = list(_MEANING.values())
    for number, row in enumerate(rows, start=5):
        if len(row) != width:
            raise _refused(file, number, f"{len(row)} cells; allowed: the {width} stated in line 3")
        if found := re.search(f"[^{re.escape(''.join(_MEANING))}]", row):
            wrong = f"unknown terrain {found.group()!r}; allowed: {' '.join(_MEANING)}"
            raise _refused(file, number, wrong, found.start() + 1)
    values = table[np.frombuffer("".join(rows).encode("ascii"), dtype=np.uint8)]
    return np.ascontiguousarray(values.reshape(height, width)[::-1])


def _size(file: str, lines: list[str]) -> tuple[int, int]:
    numbers = []
    for number, (key, pattern) in enumerate(_HEADER, start=1):
        line = lines[number - 1].strip() if number <= len(lines) else ""
        found = re.fullmatch(pattern, line)
        if found is None:
            allowed = "type octile" if key == "type" else f"{key} and a number"
            raise _refused(file, number, f"{line[:40]!r} is not a line of a MovingAI map; allowed: {allowed}")
        numbers += [int(group) for group in found.groups()]
    if len(lines) < 4 or lines[3].strip() != "map":
        raise _refused(file, 4, "the line 'map' before the rows is missing; allowed: map")
    height, width = numbers
    if not 0 < height * width <= MAX_PIXELS:
        raise _refused(file, 2, f"{width} x {height} cells; allowed: at least one, {MAX_PIXELS} in all")
    return height, width


def _refused(file: str, line: int, wrong: str, column: int = 1) -> FileError:
    return FileError([Finding(file, line, column, wrong)])
