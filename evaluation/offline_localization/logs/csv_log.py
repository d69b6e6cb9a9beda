"""Reading of a recorded log in CSV with a header in YAML."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from handcart.backends.robot.localization.noise_model import beacon_errors
from handcart.files.csv_table import CsvLine, csv_rows, number_in
from handcart.files.errors import FileError, Finding
from handcart.files.findings import Findings
from handcart.files.models.loading import Loaded, load_document
from handcart.files.regular_file import BYTE_ORDER_MARK, decode_text, read_regular_file
from handcart.files.suggest import listed
from handcart.files.yaml.yaml_document import parse_document
from handcart.robotics.geometry.earth_frame import EarthFrame
from handcart.robotics.numerics.arrays import FloatArray

from .column_names import named_columns
from .drive_log import BeaconLog, DriveLog
from .log_header import UNIT_FACTORS, LogHeader
from .places import checked_places

MAX_BYTES = 1 << 28
HEADER_MARK = "---"
MAX_SHOWN_CELLS = 10  # invalid cells reported one by one
GRAVITY_M_S2 = 9.81


def read_csv_log(path: Path, columns: str | None = None) -> DriveLog:
    """Read the log in a CSV file.

    Args:
        path: a CSV file with a header in YAML, or only with a line of titles.
        columns: definition `QUANTITY=COLUMN[:UNIT],...` of the columns, if the file has no header.

    Raises:
        FileError: header or table have faults; it lists all faults.
    """
    text = decode_text(read_regular_file(path, MAX_BYTES).removeprefix(BYTE_ORDER_MARK), str(path))
    lines = text.splitlines()
    if columns is not None:
        header = named_columns(columns)
        return _read_table(path, lines, 1, header, _delimiter(lines))
    if (
        not lines
        or lines[0].strip() != HEADER_MARK
        or HEADER_MARK not in [line.strip() for line in lines[1:]]
    ):
        wrong = (
            "no log: it doesn't begin with a header between two lines '---'; see docs/how_to/localize.md, or "
        )
        wrong += "name its columns: --columns t=COLUMN,v=COLUMN,lat=COLUMN,lon=COLUMN,gyro_z=COLUMN:deg/s"
        raise FileError([Finding(str(path), 1, 1, wrong)])
    end = next(k for k, line in enumerate(lines[1:], start=1) if line.strip() == HEADER_MARK)
    header = load_document(parse_document("\n".join(["", *lines[1:end]]).encode(), str(path)), LogHeader)
    return _read_table(path, lines[end + 1 :], end + 2, header, ",")


def _read_table(
    path: Path, lines: list[str], first: int, header: Loaded[LogHeader], delimiter: str
) -> DriveLog:
    """Return the log of a table whose first line has the number `first`."""
    scales = _scales(header)
    columns = _table(path, lines, first, header, delimiter)
    values = {name: scale * columns[name] for name, scale in scales.items()}
    _take_out_held(values, header.value)
    notes = list[str]()
    if "latitude" in values:
        latitudes, longitudes, notes = checked_places(values["latitude"], values["longitude"], values["time"])
        values |= {"latitude": latitudes, "longitude": longitudes}
    return _log(values, header.value)._replace(notes=tuple(notes))


def _delimiter(lines: list[str]) -> str:
    """Return the usual delimiter that occurs most often in the line of titles."""
    title = lines[0] if lines else ""
    return max(",;\t", key=title.count)


def _scales(header: Loaded[LogHeader]) -> dict[str, float]:
    """Return the factor that converts each column to SI units."""
    findings, scales, quantities = Findings(), {}, header.value.quantities
    for quantity, column in header.value.columns.items():
        if quantity not in quantities:
            allowed = f"no such quantity: {quantity!r}; allowed: {listed(quantities)}"
            findings.add(header.finding(("columns", quantity), allowed, at_key=True))
            continue
        units = {unit: scale for what in quantities[quantity] for unit, scale in UNIT_FACTORS[what].items()}
        if column.unit not in units:
            allowed = f"no unit of {quantity}: {column.unit!r}; allowed: {listed(units)}"
            findings.add(header.finding(("columns", quantity, "unit"), allowed))
            continue
        scales[quantity] = column.factor * units[column.unit]
    for wanted, why in _needed(header.value):
        findings.add(header.finding(("columns",), f"{wanted}; needed: {why}", at_key=True))
    findings.raise_all()
    return scales


def _needed(header: LogHeader) -> list[tuple[str, str]]:
    """Return what is missing in the header, each with the columns that would provide it."""
    has, missing = header.columns.keys(), []
    if "time" not in has:
        missing.append(("no times", "time"))
    if not {"wheel_left", "wheel_right"} <= has and "speed" not in has:
        missing.append(("nothing tells how far it drove", "wheel_left and wheel_right, or speed"))
    turns = "gyro_z" in has or ("steering" in has and header.wheelbase_m is not None)
    if not turns and not ({"wheel_left", "wheel_right"} <= has and header.tread_m is not None):
        ways = "gyro_z, or steering and wheelbase_m, or both wheels and tread_m"
        missing.append(("nothing tells how it turned", ways))
    for one, other in _PLACES:
        if (one in has) != (other in has):
            missing.append((f"{one if one in has else other} alone", f"{one} and {other}"))
    return missing


def _table(
    path: Path, lines: list[str], first: int, header: Loaded[LogHeader], delimiter: str
) -> dict[str, FloatArray]:
    """Return the values (n,) of each quantity in the column's unit; `first` is the number of the first
    line.
    """
    rows = csv_rows(lines, path, first - 1, delimiter)
    titles = [title.strip() for title in next(rows, CsvLine(0, [])).cells]
    findings, places = Findings(), {}
    for quantity, column in header.value.columns.items():
        name = column.name or quantity
        if name not in titles:
            wrong = f"the table has no column {name!r}; it has: {listed(titles)}"
            findings.add(header.finding(("columns", quantity), wrong, at_key=True))
        else:
            places[quantity] = titles.index(name)
    findings.raise_all()
    table: list[list[float]] = []
    at = list(places).index("time")
    for line, row in rows:
        if not any(cell.strip() for cell in row):
            continue
        if len(row) != len(titles):
            findings.add(Finding(str(path), line, 1, f"{len(row)} cells; needed: {len(titles)}"))
        else:
            table.append([_number(row, place, path, line, findings) for place in places.values()])
            if not (table[-2][at] if len(table) > 1 else -math.inf) <= table[-1][at] < math.inf:
                findings.add(Finding(str(path), line, 1, "time doesn't increase; needed: increasing times"))
        if len(findings) >= MAX_SHOWN_CELLS:
            break
    findings.raise_all()
    if len(table) < 2:
        raise FileError([Finding(str(path), first, 1, "no readings; needed: at least two rows")])
    values = np.array(table).T
    return dict(zip(places, values, strict=True))


def _number(row: list[str], place: int, path: Path, line: int, findings: Findings) -> float:
    cell = row[place].strip()
    value = number_in(cell)
    if cell and not math.isfinite(value) and cell.lower() not in ("nan", "inf", "-inf"):
        column = 1 + sum(len(text) + 1 for text in row[:place])
        findings.add(
            Finding(str(path), line, column, f"no number: {cell[:40]!r}; allowed: a number, or nothing")
        )
    return value if math.isfinite(value) else math.nan  # also of "inf": nothing was measured


def _log(values: dict[str, FloatArray], header: LogHeader) -> DriveLog:
    times = values["time"]
    order = np.diff(times)
    steps = np.concatenate([[np.median(order)], order])
    nothing = np.full(len(times), math.nan)
    wheels = _travel(values, header, steps)
    rates, steered = _rates(values, header, wheels, steps)
    felt = [values.get(f"accelerometer_{axis}", np.full(len(times), still)) for axis, still in _STILL]
    reference = np.stack([values.get(name, nothing) for name in ("true_x", "true_y", "true_heading")], axis=1)
    origin = None
    if _TRUE[0] in values:
        about = values.get("latitude", values[_TRUE[0]]), values.get("longitude", values[_TRUE[1]])
        origin = first_place(*about)
        reference[:, :2] = plane(values[_TRUE[0]], values[_TRUE[1]], origin)
    turns = _wheel_turns(values, header, wheels, steps)
    start = header.start
    heading = math.nan if start.heading_deg is None else math.radians(start.heading_deg)
    x, y = (math.nan if item is None else item for item in (start.x_m, start.y_m))
    return DriveLog(
        times,
        rates,
        np.stack(felt, axis=1),
        wheels,
        _fixes(values, nothing),
        values.get("gps_sigma", nothing),
        reference,
        (x, y, heading),
        header.antenna_m,
        steered,
        _ranges(values, header, nothing),
        odometry_turns=turns,
        origin=origin,
    )


def _wheel_turns(
    values: dict[str, FloatArray], header: LogHeader, wheels: FloatArray, steps: FloatArray
) -> FloatArray | None:
    """Return the turn rate (n,) by the two wheels, in [rad/s], positive to the left; None without wheels and
    tread.

    Args:
        values: values (n,) of each quantity in SI units.
        header: header of the log.
        wheels: (n, 2) travel of the left and right wheel since the previous row, in [m].
        steps: (n,) time since the previous row, in [s].
    """
    if header.tread_m is None or not {"wheel_left", "wheel_right"} <= values.keys():
        return None
    turned = (wheels[:, 1] - wheels[:, 0]) / header.tread_m
    return np.divide(turned, steps, out=np.zeros(len(steps)), where=steps > 0.0)


def _ranges(values: dict[str, FloatArray], header: LogHeader, nothing: FloatArray) -> BeaconLog | None:
    if header.beacons is None or not header.columns.keys() & set(header.range_columns):
        return None
    ranges = np.stack([values.get(name, nothing) for name in header.range_columns], axis=1)
    return BeaconLog(beacon_errors(header.beacons), ranges)


def _take_out_held(values: dict[str, FloatArray], header: LogHeader) -> None:
    """Replace repeated values of columns marked `held` by NaN, in place.

    Of columns that a sensor writes together, such as the two of a place, only if all repeat: the heading of a
    straight drive stays the same in a new pose. A stated accuracy is kept: it counts only with a fix, and
    equal accuracies of new fixes are usual.
    """
    together = (*_PLACES[:2], ("true_x", "true_y", *_TRUE, "true_heading"))
    others = values.keys() - {name for names in together for name in names} - {"gps_sigma", "time"}
    for names in (*together, *((name,) for name in sorted(others))):
        held = [values[name] for name in names if name in values and header.columns[name].held]
        if held:
            again = np.all([item[1:] == item[:-1] for item in held], axis=0)
            for item in held:
                item[1:][again] = math.nan


_TRUE = ("true_latitude", "true_longitude")
_PLACES = (("gps_east", "gps_north"), ("latitude", "longitude"), ("true_x", "true_y"), _TRUE)
_STILL = (("x", 0.0), ("y", 0.0), ("z", GRAVITY_M_S2))  # readings of missing accelerometers


def _travel(values: dict[str, FloatArray], header: LogHeader, steps: FloatArray) -> FloatArray:
    """Return the travel (n, 2) of the left and right wheel since the previous row, in [m].

    A speed holds until the next one.

    Args:
        values: values (n,) of each quantity in SI units.
        header: header of the log.
        steps: (n,) time since the previous row, in [s].
    """
    travel = []
    for name in ("wheel_left", "wheel_right"):
        name = name if name in values else "speed"
        is_speed = header.columns[name].unit in UNIT_FACTORS["speed"]
        travel.append(held_on(values[name]) * steps if is_speed else np.nan_to_num(values[name]))
    return np.stack(travel, axis=1)


def held_on(values: FloatArray) -> FloatArray:
    """Return values (n,), in any unit, with each NaN replaced by the last number before it, or by 0."""
    latest = np.maximum.accumulate(np.where(np.isfinite(values), np.arange(len(values)), 0))
    return np.nan_to_num(values[latest], posinf=0.0, neginf=0.0)


def _rates(
    values: dict[str, FloatArray], header: LogHeader, wheels: FloatArray, steps: FloatArray
) -> tuple[FloatArray, bool]:
    """Return turn rates about x, y, z (n, 3), in [rad/s], and whether z is from steering or wheels, not a
    gyro.

    Args:
        values: values (n,) of each quantity in SI units.
        header: header of the log.
        wheels: (n, 2) travel of the left and right wheel since the previous row, in [m].
        steps: (n,) time since the previous row, in [s].
    """
    across = [values.get(f"gyro_{axis}", np.zeros(len(steps))) for axis in "xy"]
    if "gyro_z" in values:
        return np.stack([*across, values["gyro_z"]], axis=1), False
    speed = np.divide(wheels.mean(axis=1), steps, out=np.zeros(len(steps)), where=steps > 0.0)
    if "steering" in values and header.wheelbase_m is not None:
        about = speed * np.tan(held_on(values["steering"])) / header.wheelbase_m
    else:
        turns = _wheel_turns(values, header, wheels, steps)
        assert turns is not None
        about = turns
    return np.stack([*across, about], axis=1), True


def _fixes(values: dict[str, FloatArray], nothing: FloatArray) -> FloatArray:
    """Return fixes (n, 2) east and north in [m]; latitude and longitude are relative to the first fix.

    Args:
        values: values (n,) of each quantity.
        nothing: (n,) NaN, for a missing quantity.
    """
    if "gps_east" in values:
        return np.stack([values["gps_east"], values["gps_north"]], axis=1)
    if "latitude" not in values:
        return np.stack([nothing, nothing], axis=1)
    place = values["latitude"], values["longitude"]
    return plane(*place, first_place(*place))


def first_place(latitudes: FloatArray, longitudes: FloatArray) -> tuple[float, float] | None:
    """Return the first known pair of latitude and longitude, in [deg]; None if no pair is known.

    Args:
        latitudes: (n,) in [deg].
        longitudes: (n,) in [deg].
    """
    known = np.flatnonzero(np.isfinite(latitudes) & np.isfinite(longitudes))
    return None if not len(known) else (float(latitudes[known[0]]), float(longitudes[known[0]]))


def plane(latitudes: FloatArray, longitudes: FloatArray, origin: tuple[float, float] | None) -> FloatArray:
    """Convert latitudes and longitudes to places on a plane.

    Args:
        latitudes: (n,) in [deg].
        longitudes: (n,) in [deg].
        origin: latitude and longitude of the plane's origin, in [deg]; None: all places are returned as NaN.

    Returns:
        (n, 2) east and north of the origin, in [m]; NaN where unknown.
    """
    found = np.full((len(latitudes), 2), math.nan)
    if origin is not None:
        known = np.isfinite(latitudes) & np.isfinite(longitudes)
        found[known] = EarthFrame(*origin).points_to_field(latitudes[known], longitudes[known])
    return found
