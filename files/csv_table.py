"""Reading a CSV file: bounded in bytes, rows and cells, with the place of each cell."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Iterator
from itertools import accumulate
from pathlib import Path
from typing import NamedTuple

from handcart.files.errors import FileError, Finding
from handcart.files.regular_file import BYTE_ORDER_MARK, decode_text, read_regular_file

MAX_BYTES = 1 << 22
_WORDS = {",": "commas", ";": "semicolons", "\t": "tabs"}


class CsvLine(NamedTuple):
    """Row of a CSV table, with the line in which it ends, from 1."""

    line: int
    cells: list[str]


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
    for number, (line, cells) in enumerate(csv_rows(text.splitlines(keepends=True), path)):
        if number > most:
            raise _refused(path, line, f"more than {most} rows; allowed: fewer")
        starts = accumulate((len(cell) + 1 for cell in cells[:-1]), initial=1)
        stripped = tuple(cell.strip() for cell in cells)
        yield CsvRow(line, stripped if any(stripped) else (), tuple(starts))


def csv_rows(
    lines: Iterable[str], path: Path | str, before: int = 0, delimiter: str = ","
) -> Iterator[CsvLine]:
    """Yield the rows of CSV text, of any number and length, also empty ones.

    Args:
        lines: the lines of the table.
        path: path of the file, named in errors.
        before: number of lines before the table in the file.
        delimiter: character between cells.

    Raises:
        FileError: the text is not CSV, such as a quotation mark that is not closed for long.
    """
    reader = csv.reader(lines, delimiter=delimiter)
    try:
        for cells in reader:
            yield CsvLine(before + reader.line_num, cells)
    except csv.Error as error:
        wrong = f"invalid CSV: {error}; allowed: cells with {_WORDS.get(delimiter, delimiter)} between"
        raise _refused(path, before + reader.line_num, wrong) from None


def number_in(cell: str) -> float:
    """Parse a cell as a decimal number in ASCII digits; NaN if it is anything else."""
    try:
        return float(cell if cell.isascii() and "_" not in cell else "nan")
    except ValueError:
        return float("nan")


def _refused(path: Path | str, line: int, wrong: str) -> FileError:
    return FileError([Finding(str(path), line, 1, wrong)])
