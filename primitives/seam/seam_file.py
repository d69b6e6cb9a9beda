"""Reading a seam: a CSV file with one pose of the tool a line."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from handcart.files.csv_table import CsvRow, number_in, read_csv
from handcart.files.errors import FileError, Finding
from handcart.files.findings import Findings
from handcart.robotics.geometry.transform import transform
from handcart.robotics.manipulation.paths.tool_path import ToolPath, tool_path
from handcart.robotics.manipulation.paths.untrackable import Untrackable
from handcart.robotics.numerics.arrays import FloatArray

SEAM_COLUMNS = ("x_m", "y_m", "z_m", "roll_deg", "pitch_deg", "yaw_deg")
MAX_SEAM_POINTS = 50_000  # points
MAX_COORDINATE = 1e6  # [m] or [deg]


def load_seam(path: Path | str) -> ToolPath:
    """Return the path of a tool on the map; the tool points along the x axis of its frame.

    The file's first line names the columns; lengths are in [m], roll, pitch and yaw in [deg] as in a URDF.
    Point i of the path is in line i + 2.

    Raises:
        FileError: the file is not a seam, or a point is bad (NaN, a repeated position, a jump); the error
            names the first bad point.
    """
    file = str(path)
    lines = read_csv(path, MAX_SEAM_POINTS)
    first = next(lines, None)
    if first is None or first.cells != SEAM_COLUMNS:
        raise _refused(file, 1, f"these are not columns of a seam; allowed: {','.join(SEAM_COLUMNS)}")
    findings = Findings()
    rows = [_row(file, line, findings) for line in lines]
    findings.raise_all()
    if len(rows) < 2:
        raise _refused(file, 1 + len(rows), f"{len(rows)} points; allowed: two or more, one a line")
    try:
        return tool_path(np.array([_pose(row) for row in rows]))
    except Untrackable as error:
        raise untrackable(file, error) from None


def untrackable(file: str, error: Untrackable) -> FileError:
    """Return the error for a point of a seam that cannot be tracked, with the line of the point in the
    file.
    """
    nearest = "" if error.nearest is None else f"; the nearest that can be reached: {_words(error.nearest)}"
    advised = nearest or "allowed: " in error.why or "needed: " in error.why
    allowed = "" if advised else "; allowed: a seam without that"
    return _refused(file, error.index + 2, f"this point {error.why}{nearest}{allowed}")


def _row(file: str, row: CsvRow, findings: Findings) -> list[float]:
    if len(row.cells) != len(SEAM_COLUMNS):
        findings.add(Finding(file, row.line, 1, f"{len(row.cells)} values; allowed: {len(SEAM_COLUMNS)}"))
        return []
    values = [number_in(cell) for cell in row.cells]
    for name, cell, value, column in zip(SEAM_COLUMNS, row.cells, values, row.columns, strict=True):
        if not abs(value) <= MAX_COORDINATE:
            wrong = f"{name} is {cell[:40]!r}; allowed: a finite number up to {MAX_COORDINATE:g}"
            findings.add(Finding(file, row.line, column, wrong))
    return values


def _pose(row: list[float]) -> FloatArray:
    return transform(row[:3], [math.radians(angle) for angle in row[3:]])


def _words(point: FloatArray) -> str:
    return "(" + ", ".join(f"{value:.3f}" for value in point) + ") m"


def _refused(file: str, line: int, wrong: str) -> FileError:
    return FileError([Finding(file, line, 1, wrong)])
