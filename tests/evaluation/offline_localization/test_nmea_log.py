"""Fixes of a receiver's NMEA log at their times in a log of wheels and gyros."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from handcart.backends.can.sensors.sensor_lines import checksum
from handcart.evaluation.offline_localization.logs.csv_log import read_csv_log
from handcart.evaluation.offline_localization.logs.drive_log import DriveLog
from handcart.evaluation.offline_localization.logs.nmea_log import with_nmea
from handcart.files.errors import FileError

LATITUDE, LONGITUDE = 47.0, 8.0
MIDNIGHT_S = 1_700_006_400.0  # 2023-11-15 00:00:00 UTC
STEP_DEG = 1e-5  # of latitude from fix to fix
STEP_M = 1.112


def recorded(
    folder: Path, begun: float, columns: dict[str, list[float]] | None = None, held: str = ""
) -> DriveLog:
    """Return a log of 20 s, with a row each 0.5 s; `held`: the columns whose values are repeated."""
    names = ["time", "speed", "gyro_z", *(columns or {})]
    units = {
        "time": "s",
        "speed": "m/s",
        "gyro_z": "rad/s",
        "gps_sigma": "m",
        "gps_east": "m",
        "gps_north": "m",
        "true_x": "m",
        "true_y": "m",
    }
    lines = ["---", "format: handcart-log/1", "columns:"]
    lines += [
        f"  {name}: {{unit: {units.get(name, 'deg')}{', held: true' if name in held.split() else ''}}}"
        for name in names
    ]
    lines += ["---", ",".join(names)]
    more = list((columns or {}).values())
    rows = [[begun + 0.5 * row, 1.0, 0.0, *(values[row] for values in more)] for row in range(41)]
    lines += [",".join("" if math.isnan(cell) else f"{cell:.9f}" for cell in row) for row in rows]
    (folder / "log.csv").write_text("\n".join(lines) + "\n")
    return read_csv_log(folder / "log.csv")


def received(folder: Path, first_utc: float, count: int = 20) -> Path:
    """Write a fix each second, each further north than the one before."""
    lines = []
    for number in range(count):
        utc = (first_utc + number) % 86_400.0
        clock = f"{int(utc // 3600):02}{int(utc // 60 % 60):02}{utc % 60:05.2f}"
        minutes = 60.0 * number * STEP_DEG
        body = f"GPGGA,{clock},{int(LATITUDE):02}{minutes:09.6f},N,{int(LONGITUDE):03}00.000000,E".encode()
        body += b",1,08,1.0,400.0,M,47.0,M,,"
        lines.append(b"$%b*%02X" % (body, checksum(body)))
    (folder / "gps.nmea").write_bytes(b"\r\n".join(lines) + b"\r\n")
    return folder / "gps.nmea"


@pytest.mark.parametrize(
    ("begun", "first_utc", "first_row", "first_fix"),
    [
        (36_000.0, 35_990.0, 0, 10),  # of the day; the receiver was on before the recorder
        (36_000.0, 36_005.0, 10, 0),
        (86_395.0, 1.0, 12, 0),  # of the day, past midnight
        (5.0, 86_399.0, 0, 6),
        (MIDNIGHT_S - 0.5, 0.0, 1, 0),
        (MIDNIGHT_S + 1.0, 86_399.0, 0, 2),
        (MIDNIGHT_S + 36_000.0, 35_990.0, 0, 10),
        (MIDNIGHT_S + 36_000.0, 36_005.0, 10, 0),
    ],
)
def test_fixes_are_at_their_utc_in_the_log(
    tmp_path: Path, begun: float, first_utc: float, first_row: int, first_fix: int
) -> None:
    log = with_nmea(recorded(tmp_path, begun), received(tmp_path, first_utc))
    rows = np.flatnonzero(np.isfinite(log.fixes).all(axis=1))
    assert rows[0] == first_row
    assert log.fixes[rows[0], 1] == pytest.approx(first_fix * STEP_M, abs=0.01)
    assert [f"from {begun:g} s on, are taken as seconds of the day in UTC" in note for note in log.notes] == (
        [True] if begun < 86_400.0 else []
    )


def test_a_clock_other_than_utc_is_noted(tmp_path: Path) -> None:
    for begun in (0.0, 5_000.0):
        log = with_nmea(recorded(tmp_path, begun), received(tmp_path, 43_200.0))
        assert np.flatnonzero(np.isfinite(log.fixes).all(axis=1)).tolist() == list(range(0, 40, 2))
        assert log.notes == (
            "the log's clock is not UTC; the first fix is assumed to coincide with the first row",
        )


def test_a_receivers_log_of_another_time_is_refused(tmp_path: Path) -> None:
    log = recorded(tmp_path, MIDNIGHT_S + 36_000.0)
    with pytest.raises(FileError, match=r"no fix within the log: the fixes end 81\.0 s before its first row"):
        with_nmea(log, received(tmp_path, 35_900.0))
    with pytest.raises(FileError, match=r"the fixes begin 80\.0 s after its last row"):
        with_nmea(log, received(tmp_path, 36_100.0))


def test_fixes_and_a_reference_in_degrees_have_one_origin(tmp_path: Path) -> None:
    true = {
        "true_latitude": [LATITUDE + (3 + 0.5 * row) * STEP_DEG for row in range(41)],
        "true_longitude": [8.0] * 41,
    }
    log = with_nmea(recorded(tmp_path, 36_000.0, true), received(tmp_path, 36_005.0))
    rows = np.flatnonzero(np.isfinite(log.fixes).all(axis=1))
    assert (log.reference[rows, 1] - log.fixes[rows, 1]) == pytest.approx(8 * STEP_M, abs=0.01)


def test_new_fixes_keep_an_accuracy_that_stays_the_same(tmp_path: Path) -> None:
    columns = {
        "gps_east": [0.0 if row % 2 else row / 2 for row in range(41)],
        "gps_north": [float("nan") if row % 2 else 0.0 for row in range(41)],
        "gps_sigma": [0.8] * 41,
    }
    log = recorded(tmp_path, 0.0, columns, held="gps_sigma")
    rows = np.isfinite(log.fixes).all(axis=1)
    assert rows.sum() == 21
    assert log.sigmas[rows].tolist() == [0.8] * 21


def test_a_held_reference_keeps_the_heading_of_a_straight_drive(tmp_path: Path) -> None:
    columns = {
        "true_x": [float(row // 2) for row in range(41)],
        "true_y": [0.0] * 41,
        "true_heading": [90.0] * 41,
    }
    log = recorded(tmp_path, 0.0, columns, held="true_x true_y true_heading")
    known = np.isfinite(log.reference)
    assert known[:, 0].nonzero()[0].tolist() == list(range(0, 41, 2))
    assert (known[:, 2] == known[:, 0]).all()
    assert (known[:, 1] == known[:, 0]).all()
