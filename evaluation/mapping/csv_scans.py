"""Reader of scans with odometry in CSV, with a header in YAML that describes the lidar."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from handcart.files.csv_table import CsvLine, csv_rows, number_in
from handcart.files.errors import FileError, Finding
from handcart.files.findings import Findings
from handcart.files.models.loading import Loaded, load_document
from handcart.files.models.model import FileModel
from handcart.files.regular_file import BYTE_ORDER_MARK, decode_text, read_regular_file
from handcart.files.yaml.yaml_document import parse_document
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.mapping.scan_log import ScanLog
from handcart.robotics.numerics.arrays import FloatArray

MAX_BYTES = 1 << 29
HEADER_MARK = "---"
POSE_COLUMNS = ("time_s", "x_m", "y_m", "heading_rad")
MAX_SHOWN_CELLS = 10
MAX_BEAMS = 10_000
Degrees = Annotated[float, Field(ge=-360.0, le=360.0)]
Metres = Annotated[float, Field(ge=-100.0, le=100.0)]


class LidarHeader(FileModel):
    """Beams and mounting of the lidar, in the header of a log of scans in CSV."""

    first_deg: Degrees
    """Angle of the first beam, counter-clockwise from the sensor's x axis."""
    last_deg: Degrees
    """Angle of the last beam."""
    reach_m: Annotated[float, Field(gt=0.0, le=1000.0)]
    """Maximum range."""
    range_min_m: Annotated[float, Field(ge=0.0, le=100.0)] = 0.0
    """Readings below this value are ignored."""
    x_m: Metres = 0.0
    """Position of the sensor on the base, forward."""
    y_m: Metres = 0.0
    """Position of the sensor on the base, to the left."""
    heading_deg: Degrees = 0.0
    """Direction of the sensor's x axis on the base."""


class ScansHeader(FileModel):
    """Header, in YAML, of a log of lidar scans in CSV, with the file's format and the lidar."""

    format: Literal["handcart-scans/1"]
    """Format of the file, with its version."""
    lidar: LidarHeader
    """Lidar that made the scans."""


def read_csv_scans(path: Path) -> ScanLog:
    """Read a log with the columns time_s, x_m, y_m, heading_rad and one column for each beam's range, in [m].

    Raises:
        FileError: header or table have faults; it lists them, up to `MAX_SHOWN_CELLS` faulty cells.
    """
    text = decode_text(
        read_regular_file(path, MAX_BYTES).removeprefix(BYTE_ORDER_MARK), str(path), longest_line=None
    )
    lines = text.splitlines()
    marks = [k for k, line in enumerate(lines) if line.strip() == HEADER_MARK][:2]
    if len(marks) < 2 or marks[0] != 0:
        wrong = "no log of scans: it does not begin with a header between two lines '---'"
        raise FileError([Finding(str(path), 1, 1, f"{wrong}; see docs/how_to/map.md")])
    header = load_document(
        parse_document("\n".join(["", *lines[1 : marks[1]]]).encode(), str(path)), ScansHeader
    )
    lidar = header.value.lidar
    if lidar.last_deg <= lidar.first_deg:
        wrong = f"last_deg is {lidar.last_deg:g}; allowed: more than first_deg, {lidar.first_deg:g}"
        raise header.refuse(("lidar", "last_deg"), wrong)
    return _log(_table(path, lines, marks[1] + 1), header)


def _table(path: Path, lines: list[str], first: int) -> FloatArray:
    """Return the numbers (n, 4 + beams) of the table, whose titles are in line `first`, counted from 0."""
    rows, findings = csv_rows(lines[first:], path, first), Findings()
    titles = [title.strip() for title in next(rows, CsvLine(0, [])).cells]
    if tuple(titles[:4]) != POSE_COLUMNS or not 2 <= len(titles) - 4 <= MAX_BEAMS:
        wrong = f"titles {', '.join(titles[:5])[:80]} ...; needed: {', '.join(POSE_COLUMNS)}, then one a beam"
        raise FileError([Finding(str(path), first + 1, 1, wrong)])
    table, last = list[list[float]](), -math.inf
    for line, row in rows:
        if not any(cell.strip() for cell in row):
            continue
        if len(row) != len(titles):
            findings.add(Finding(str(path), line, 1, f"{len(row)} cells; needed: {len(titles)}"))
        else:
            table.append(_numbers(row, path, line, findings))
            if not last < table[-1][0] < math.inf:
                findings.add(Finding(str(path), line, 1, "time does not increase; needed: increasing times"))
            last = table[-1][0]
        if len(findings) >= MAX_SHOWN_CELLS:
            break
    findings.raise_all()
    if len(table) < 2:
        raise FileError([Finding(str(path), first + 1, 1, "no scans; needed: at least two rows")])
    return np.array(table)


def _numbers(row: list[str], path: Path, line: int, findings: Findings) -> list[float]:
    """Return the numbers of a row; a range may be empty, nan or inf."""
    found, column = list[float](), 1
    for place, cell in enumerate(row):
        value, word = number_in(cell.strip()), cell.strip().lower()
        is_pose = place < len(POSE_COLUMNS)
        is_known = math.isfinite(value) and abs(value) < 1e12
        if not is_known and (is_pose or word not in ("", "nan", "inf", "-inf", "infinity")):
            allowed = "a number" if is_pose else "a number, inf for nothing in reach, or nothing"
            findings.add(Finding(str(path), line, column, f"no number: {cell[:40]!r}; allowed: {allowed}"))
        found.append(value)
        column += len(cell) + 1
    return found


def _log(table: FloatArray, header: Loaded[ScansHeader]) -> ScanLog:
    lidar = header.value.lidar
    ranges = table[:, 4:].copy()
    ranges[(ranges < max(lidar.range_min_m, 1e-6))] = math.nan
    ranges[ranges > lidar.reach_m] = math.inf
    angles = np.radians(np.linspace(lidar.first_deg, lidar.last_deg, ranges.shape[1]))
    mount = Pose2(lidar.x_m, lidar.y_m, math.radians(lidar.heading_deg))
    return ScanLog(table[:, 0], table[:, 1:4], angles, ranges, mount, lidar.reach_m)
