"""Columns of any CSV file, as named on the command line."""

from __future__ import annotations

from handcart.files.errors import FileError, Finding
from handcart.files.models.loading import Loaded, load_document
from handcart.files.suggest import suggest
from handcart.files.yaml.yaml_document import parse_document

from .log_header import COLUMN_QUANTITIES, UNIT_FACTORS, LogHeader

COLUMNS_OPTION = "--columns"
SHORT_NAMES = {
    "t": "time",
    "v": "speed",
    "x": "gps_east",
    "y": "gps_north",
    "lat": "latitude",
    "lon": "longitude",
    "w": "gyro_z",
    "sigma": "gps_sigma",
}
"""Short names of quantities."""
SETTING_NAMES = ("tread_m", "wheelbase_m")


def named_columns(text: str) -> Loaded[LogHeader]:
    """Parse the definition `QUANTITY=COLUMN[:UNIT],...` of a log's columns to a header.

    Without a unit, a column is in the first unit of its quantity: s, m, m/s, rad/s, deg for latitudes
    and longitudes.

    Raises:
        FileError: a part does not have this form, or names an unknown quantity.
    """
    findings, columns, settings = list[Finding](), list[str](), list[str]()
    for part in filter(None, (part.strip() for part in text.split(","))):
        name, equals, column = part.partition("=")
        quantity = SHORT_NAMES.get(name.strip(), name.strip())
        title, colon, unit = column.rpartition(":")
        title, unit = (title, unit) if colon else (column, "")
        if quantity in SETTING_NAMES:
            settings.append(f"{quantity}: {column.strip()}")
        elif quantity not in COLUMN_QUANTITIES:
            allowed = suggest(quantity, [*COLUMN_QUANTITIES, *SHORT_NAMES, *SETTING_NAMES])
            findings.append(Finding(COLUMNS_OPTION, 0, 0, f"unknown quantity {quantity!r}{allowed}"))
        elif not equals or not title.strip():
            wrong = f"{part!r} names no column; allowed: QUANTITY=COLUMN or QUANTITY=COLUMN:UNIT"
            findings.append(Finding(COLUMNS_OPTION, 0, 0, wrong))
        else:
            unit = unit.strip() or next(iter(UNIT_FACTORS[COLUMN_QUANTITIES[quantity][0]]))
            columns.append(f"  {quantity}: {{unit: {_quoted(unit)}, name: {_quoted(title.strip())}}}")
    if findings:
        raise FileError(findings)
    lines = ["format: handcart-log/1", *settings, "columns:", *columns]
    return load_document(parse_document("\n".join(lines).encode(), COLUMNS_OPTION), LogHeader)


def _quoted(word: str) -> str:
    """Return a word with YAML's single quotes."""
    return "'" + word.replace("'", "''") + "'"
