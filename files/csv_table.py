"""Reading a CSV file: bounded in bytes, rows and cells, with the place of each cell."""

from __future__ import annotations

import csv
from collections.abc import Iterator
from itertools import accumulate
from pathlib import Path
from typing import NamedTuple

from handcart.files.errors import FileError, Finding
from handcart.files.regular_file import BYTE_ORDER_MARK, decode_text, read_regular_file

MAX_BYTES = 1 << 22


class CsvRow(NamedTuple):
    """Row of a CSV file, with the line in which it ends and the column in which each cell begins.

    Lines and columns count from 1.
    """

    line: int
    cells: tuple[str, ...]
    """Texts of the cells, without spaces around them."""
    columns: tuple[int, ...]


def read_csv(path: Path | str, most: int, max_bytes: int = MAX_BYTES) -> Iterator[CsvRow]:
    """Yield the rows of a CSV file in UTF-8, the header first; an empty row has no cells.

    Args:
        path: the file.
        most: maximum number of rows, not counting the header.
        max_bytes: maximum size of the file, in [bytes].

    Raises:
        FileError: the file cannot be read, is not text or is too large, has a line too long or too many
            rows.
    """
    content = read_regular_file(path, max_bytes)
    # Spreadsheets begin with one.
    text = decode_text(content.removeprefix(BYTE_ORDER_MARK), str(path))
    reader = csv.reader(text.splitlines(keepends=True))
    try:
        for number, cells in enumerate(reader):
            if number > most:
                raise _refused(path, reader.line_num, f"more than {most} rows; allowed: fewer")
            starts = accumulate((len(cell) + 1 for cell in cells[:-1]), initial=1)
            stripped = tuple(cell.strip() for cell in cells)
            yield CsvRow(reader.line_num, stripped if any(stripped) else (), tuple(starts))
    except csv.Error as error:
        raise _refused(
            path, reader.line_num, f"invalid CSV: {error}; allowed: cells with commas between"
        ) from None


def number_in(cell: str) -> float:
    """Parse a cell as a decimal number in ASCII digits; NaN if it is anything else."""
    try:
        return float(cell if cell.isascii() and "_" not in cell else "nan")
    except ValueError:
        return float("nan")


def _refused(path: Path | str, line: int, wrong: str) -> FileError:
    return FileError([Finding(str(path), line, 1, wrong)])
