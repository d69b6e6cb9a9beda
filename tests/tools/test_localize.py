"""`handcart localize`: recorded logs, as their owners have them."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.field.field_course import straight_course, zigzag_course
from benchmarks.field.field_drive import PERIOD_S, FieldTimes
from benchmarks.field.field_log import FieldLog, record_course
from handcart.backends.can.sensors.sensor_lines import checksum
from handcart.evaluation.offline_localization.logs.csv_log import read_csv_log
from handcart.evaluation.offline_localization.replay import localizer_for, replay
from handcart.robotics.navigation.outdoors.field_noise import REFERENCE_NOISE

COLUMNS = {
    "time": "ms",
    "gyro_z": "deg/s",
    "wheel_left": "mm",
    "wheel_right": "mm",
    "gps_east": "m",
    "gps_north": "m",
    "true_x": "m",
    "true_y": "m",
    "true_heading": "deg",
}
LATITUDE, LONGITUDE = 47.0, 8.0
METRES = 111_170.0  # of a degree of latitude there, about


@pytest.fixture(scope="module")
def drive() -> FieldLog:
    return record_course(straight_course(3), REFERENCE_NOISE, 1, FieldTimes(wait=20.0, dwell=10.0))


def write(path: Path, log: FieldLog, header: str = "", columns: dict[str, str] | None = None) -> Path:
    """Write a log as CSV with the columns `COLUMNS`; `columns`: units of those that the header describes."""
    stated = COLUMNS if columns is None else columns
    fixes = dict(zip(log.fix_rows.tolist(), log.fixes, strict=True))
    lines = ["---", "format: handcart-log/1", *header.splitlines(), "columns:"]
    lines += [f"  {name}: {{unit: {unit}}}" for name, unit in stated.items()]
    lines += ["---", ",".join(COLUMNS)]
    for row, (pose, travel) in enumerate(zip(log.drive.poses, 1e3 * log.wheels, strict=True)):
        turn = math.degrees(log.rates[row, 2])
        place = [f"{item:.3f}" for item in fixes[row]] if row in fixes else ["", ""]
        true = (pose[0], pose[1], math.degrees(pose[2]))
        cells = [f"{1e3 * PERIOD_S * row:.0f}", f"{turn:.4f}", *(f"{item:.3f}" for item in travel), *place]
        lines.append(",".join([*cells, *(f"{item:.3f}" for item in true)]))
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


@pytest.fixture
def localized(handcart: Callable[..., Any]) -> Callable[..., dict[str, Any]]:
    """Return a function that runs the command and returns its JSON output."""

    def call(*arguments: object) -> dict[str, Any]:
        said = handcart("localize", *arguments, "--json")
        assert said.status == 0, said.err
        found: dict[str, Any] = json.loads(said.out)
        return found

    return call


@pytest.fixture
def refused(handcart: Callable[..., Any]) -> Callable[..., str]:
    """Return a function that runs the command with bad input and returns its error text."""

    def call(*arguments: object) -> str:
        said = handcart("localize", *arguments)
        assert said.status == 2
        return str(said.err)

    return call


@pytest.mark.slow
def test_a_log_is_played_with_track_and_picture(
    tmp_path: Path, drive: FieldLog, localized: Callable[..., dict[str, Any]]
) -> None:
    start = "start: {x_m: 0.0, y_m: 0.0, heading_deg: 0.0}"
    log, picture, track = (
        write(tmp_path / "log.csv", drive, start),
        tmp_path / "p.svg",
        tmp_path / "track.csv",
    )
    found = localized(log, "-o", picture, "--track", track)
    assert found["fixes"] == len(drive.fixes)
    assert found["heading_known_after_s"] == 0.0
    assert found["error_m_rms"] < 0.5
    assert 0.05 < found["nees"] < 8.0
    assert picture.stat().st_size > 5_000
    rows = np.genfromtxt(track, delimiter=",", names=True)
    (tmp_path / "drive.csv").write_bytes(log.read_bytes())
    assert localized(tmp_path)["fixes"] == found["fixes"]
    assert rows["x_m"][-1] == pytest.approx(drive.drive.poses[-1, 0], abs=1.0)


def test_nothing_is_known_of_the_start(
    tmp_path: Path, drive: FieldLog, localized: Callable[..., dict[str, Any]]
) -> None:
    found = localized(write(tmp_path / "log.csv", drive))
    assert 0.0 < found["heading_known_after_s"] < 80.0
    assert found["error_m_rms"] < 1.0


def test_wheels_alone_turn_by_their_tread(tmp_path: Path, localized: Callable[..., dict[str, Any]]) -> None:
    columns = {name: unit for name, unit in COLUMNS.items() if name != "gyro_z"}
    log = record_course(zigzag_course(4), REFERENCE_NOISE, 1, FieldTimes(wait=20.0, dwell=10.0))
    found = localized(write(tmp_path / "log.csv", log, "tread_m: 0.6", columns))
    assert found["error_m_rms"] < 1.2


def test_speed_and_steering_are_an_odometry(
    tmp_path: Path, drive: FieldLog, localized: Callable[..., dict[str, Any]]
) -> None:
    """The yaw rate of a car without a gyro follows from the steering angle (Ackermann)."""
    driven = drive.drive.driven
    lines = ["---", "format: handcart-log/1", "wheelbase_m: 0.9", "columns:"]
    units = {"time": "s", "speed": "km/h", "steering": "deg", "gps_east": "m", "gps_north": "m"}
    lines += [
        f"  {name}: {{unit: {unit}}}" for name, unit in (units | {"true_x": "m", "true_y": "m"}).items()
    ]
    lines += ["---", "time,speed,steering,gps_east,gps_north,true_x,true_y"]
    fixes = dict(zip(drive.fix_rows.tolist(), drive.fixes, strict=True))
    for row, (way, bend) in enumerate(driven):
        place = ",".join(f"{item:.3f}" for item in fixes[row]) if row in fixes else ","
        steer = math.degrees(math.atan(0.9 * bend))
        x, y = drive.drive.poses[row, :2]
        lines.append(f"{PERIOD_S * row:.3f},{3.6 * way / PERIOD_S:.4f},{steer:.4f},{place},{x:.3f},{y:.3f}")
    log = tmp_path / "car.csv"
    log.write_text("\n".join(lines) + "\n", encoding="utf-8")
    assert localized(log)["error_m_rms"] < 1.5


def _typed_by_hand(line: bytes) -> bytes:
    body = line[1:].partition(b"*")[0].replace(b",E,1,", b",E,7,")
    return b"$%b*%02X" % (body, checksum(body))


def test_a_receivers_own_log_gives_the_fixes(
    tmp_path: Path, drive: FieldLog, localized: Callable[..., dict[str, Any]], refused: Callable[..., str]
) -> None:
    columns = {name: unit for name, unit in COLUMNS.items() if not name.startswith("gps")}
    lines = [b"$GPGGA,damaged*00", b"rubbish \xff"]
    for row, (x, y) in zip(drive.fix_rows, drive.fixes, strict=True):
        seconds = 12 * 3600 + PERIOD_S * row
        clock = f"{int(seconds // 3600):02}{int(seconds // 60 % 60):02}{seconds % 60:05.2f}"
        lat = LATITUDE + y / METRES
        lon = LONGITUDE + x / (METRES * math.cos(math.radians(LATITUDE)))
        place = f"{int(lat):02}{lat % 1 * 60:09.6f},N,{int(lon):03}{lon % 1 * 60:09.6f},E"
        body = f"GPGGA,{clock},{place},1,08,1.0,400.0,M,47.0,M,,".encode()
        lines.append(b"$%b*%02X" % (body, checksum(body)))
    nmea = tmp_path / "gps.nmea"
    nmea.write_bytes(b"\r\n".join(lines) + b"\r\n")
    log = write(tmp_path / "log.csv", drive, columns=columns)
    found = localized(log, "--nmea", nmea)
    assert found["fixes"] == len(drive.fixes)
    assert found["error_m_rms"] < 2.0  # about the first fix, which is off by itself
    nmea.write_bytes(b"\r\n".join(_typed_by_hand(line) for line in lines[2:]))
    assert f"skipped {len(lines) - 2} places of quality 7: typed in by hand" in refused(log, "--nmea", nmea)
    nmea.write_bytes(b"nothing\r\n")
    assert "no fix in it" in refused(log, "--nmea", nmea)


def test_a_heading_that_stays_unknown_is_no_good_sign(tmp_path: Path, drive: FieldLog) -> None:
    """Fixes that came before it was known count too: else the worst receiver would be the likeliest."""
    log = read_csv_log(write(tmp_path / "log.csv", drive, ""))
    hopeless = REFERENCE_NOISE._replace(gps_white=60.0)
    known, unknown = (
        replay(log, localizer_for(log, noise, alone=True)) for noise in (REFERENCE_NOISE, hopeless)
    )
    assert known.known[-1]
    assert not unknown.known[-1]
    assert known.log_likelihood > unknown.log_likelihood + 50.0


@pytest.mark.slow
def test_noise_is_fitted_to_a_log(tmp_path: Path, localized: Callable[..., dict[str, Any]]) -> None:
    """The receiver is four times as good as its file says."""
    log = record_course(straight_course(4), REFERENCE_NOISE._replace(gps_white=0.25), 2)
    found = localized(
        write(tmp_path / "log.csv", log, "start: {x_m: 0.0, y_m: 0.0, heading_deg: 0.0}"), "--fit"
    )
    fitted = found["fit"]
    assert isinstance(fitted, dict)
    assert fitted["turned"]["fixes, white"] == pytest.approx(0.25, rel=0.3)
    assert fitted["log_likelihood"][1] > fitted["log_likelihood"][0] + 50.0


@pytest.mark.parametrize(
    ("header", "columns", "wrong"),
    [
        ("", {"time": "s", "gyro_q": "s"}, "no such quantity: 'gyro_q'"),
        ("", {"time": "s", "gyro_z": "grad"}, "no unit of gyro_z: 'grad'; allowed: rad/s, deg/s"),
        ("", {"time": "ms", "gyro_z": "deg/s"}, "nothing tells how far it drove"),
        ("", {"time": "ms", "wheel_left": "mm", "wheel_right": "mm"}, "nothing tells how it turned"),
        ("", {"time": "ms", "speed": "m/s", "gyro_z": "deg/s"}, "the table has no column 'speed'"),
        ("colour: red", COLUMNS, "colour"),
    ],
)
def test_what_is_wrong_in_the_header_is_told(
    tmp_path: Path,
    drive: FieldLog,
    header: str,
    columns: dict[str, str],
    wrong: str,
    refused: Callable[..., str],
) -> None:
    log = write(tmp_path / "log.csv", drive, header, columns)
    said = refused(log)
    assert wrong in said
    assert f"{log}:" in said


@pytest.mark.parametrize(
    ("line", "instead", "wrong"),
    [
        (20, "1,2", "2 cells; needed: 9"),
        (20, "x,0,0,0,,,0,0,0", "no number: 'x'"),
        (20, "0,0,0,0,,,0,0,0", "time doesn't increase"),
        (20, ",0,0,0,,,0,0,0", "time doesn't increase"),
        (20, "inf,0,0,0,,,0,0,0", "time doesn't increase"),
    ],
)
def test_what_is_wrong_in_the_table_is_told(
    tmp_path: Path, drive: FieldLog, line: int, instead: str, wrong: str, refused: Callable[..., str]
) -> None:
    log = write(tmp_path / "log.csv", drive)
    lines = log.read_text(encoding="utf-8").splitlines()
    lines[line - 1] = instead
    log.write_text("\n".join(lines), encoding="utf-8")
    said = refused(log)
    assert wrong in said
    assert f"{log}:{line}:" in said


def test_an_open_quotation_mark_is_refused_at_its_row(tmp_path: Path, refused: Callable[..., str]) -> None:
    log = tmp_path / "log.csv"
    log.write_text('t,v,w\n0,"0,0\n' + "1,0,0\n" * 30_000, encoding="utf-8")
    assert f"{log}:26216:1: invalid CSV: field larger" in refused(log, "--columns", "t=t,v=v,gyro_z=w")


def test_infinite_readings_are_missing_ones(tmp_path: Path, drive: FieldLog) -> None:
    log = write(tmp_path / "log.csv", drive)
    lines = log.read_text(encoding="utf-8").splitlines()
    read = []
    for missing in ("", "inf"):
        time, *_ = lines[39].split(",")
        lines[39] = ",".join([time, *[missing] * 8])
        log.write_text("\n".join(lines), encoding="utf-8")
        read.append(read_csv_log(log))
    blank, infinite = read
    for one, other in zip(blank[:6], infinite[:6], strict=True):
        assert np.array_equal(one, other, equal_nan=True)


def test_times_that_are_marked_held_stay_times(tmp_path: Path, drive: FieldLog) -> None:
    """Two rows may have one time, such as rows of two sensors."""
    log = write(tmp_path / "log.csv", drive)
    text = log.read_text(encoding="utf-8").replace("time: {unit: ms}", "time: {unit: ms, held: true}")
    lines = text.splitlines()
    lines[40] = ",".join([lines[39].split(",")[0], *lines[40].split(",")[1:]])
    log.write_text("\n".join(lines), encoding="utf-8")
    assert np.isfinite(read_csv_log(log).times).all()


def test_a_csv_of_any_tool_is_played_by_its_columns(
    tmp_path: Path, drive: FieldLog, localized: Callable[..., dict[str, Any]], refused: Callable[..., str]
) -> None:
    with_header = write(tmp_path / "log.csv", drive)
    lines = with_header.read_text(encoding="utf-8").splitlines()
    table = lines[lines.index("---", 1) + 1 :]
    plain = tmp_path / "plain.csv"
    titles = "stamp;rate;left;right;east;north;a;b;c"
    plain.write_text("\n".join([titles, *(row.replace(",", ";") for row in table[1:])]), encoding="utf-8")
    columns = (
        "t=stamp:ms,w=rate:deg/s,wheel_left=left:mm,wheel_right=right:mm,x=east,y=north,true_x=a,true_y=b"
    )
    found = localized(plain, "--columns", columns)
    same = localized(with_header)
    assert found["error_m_rms"] == pytest.approx(same["error_m_rms"])
    assert found["fixes"] == same["fixes"]
    assert "unknown quantity 'speedo'; did you mean 'speed'" in refused(
        plain, "--columns", "t=stamp,speedo=a"
    )
    assert "names no column" in refused(plain, "--columns", "t=stamp,v")
    assert "no column 'far'" in refused(plain, "--columns", columns.replace("x=east", "x=far"))
    assert "name its columns: --columns" in refused(plain)


def test_what_is_no_log_is_refused(tmp_path: Path, refused: Callable[..., str]) -> None:
    plain = tmp_path / "plain.csv"
    plain.write_text("time,x\n1,2\n", encoding="utf-8")
    assert "it doesn't begin with a header" in refused(plain)
    assert "does not exist" in refused(tmp_path / "nothing.csv")
    assert "no .mcap, .db3 or .bag file in the folder" in refused(tmp_path)
    assert "did you mean 'particle'" in refused(plain, "--localizer", "particles")
