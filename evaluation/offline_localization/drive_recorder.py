"""Recorder of wheels, gyros and GNSS receiver in a run, as a log for `handcart localize`."""

from __future__ import annotations

import math
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path
from typing import TextIO

import numpy as np
from typing_extensions import override

from handcart.backends.robot.robot import Robot
from handcart.files.csv_table import number_in
from handcart.networks.events.events import Event
from handcart.networks.events.run_observer import RunObserver
from handcart.networks.task.preparing import Prepared

DRIVE_LOG_FILE = "drive.csv"
PLACE_DIGITS = 9  # significant ones: a millimetre up to 1000 km from the origin
TIME_RESOLUTION_S = 1e-4  # of the written times
COLUMN_UNITS = {
    "time": "s",
    **{f"gyro_{axis}": "rad/s" for axis in "xyz"},
    **{f"accelerometer_{axis}": "m/s2" for axis in "xyz"},
    "wheel_left": "m",
    "wheel_right": "m",
    "gps_east": "m",
    "gps_north": "m",
    "gps_sigma": "m",
    "true_x": "m",
    "true_y": "m",
    "true_heading": "rad",
}
"""Units of the columns, by name."""


class DriveRecorder(RunObserver):
    """Observer that logs the readings for localization of an outdoor robot, one row per period.

    In simulation the log also has the true pose. A write error, for example a full disk, ends the log but
    not the run.
    """

    def __init__(self) -> None:
        self._file: TextIO | None = None
        self._robot: Robot | None = None
        self._noted, self._beacons = 0.0, 0

    def begin(self, prepared: Prepared, run_dir: Path) -> None:
        """Open the log file; for a continued run, keep the rows before the time of its continuation."""
        robot = prepared.robot
        if robot.localization.sensed is None:
            return
        self._robot, self._noted = robot, robot.time
        beacons = robot.spec.beacons
        self._beacons = 0 if beacons is None else len(beacons.places_m)
        path = run_dir / DRIVE_LOG_FILE
        with suppress(OSError):
            lines = _kept(path, robot.time) if path.exists() else [_header(robot)]
            self._file = path.open("w", encoding="utf-8")
            self._file.writelines(lines)

    @override
    def period(self, robot: Robot) -> None:
        self._note(robot)

    def event(self, event: Event) -> None:
        """Flush the log to disk at each event of the run, so that a killed run can be continued from the end
        of its last action.
        """
        if self._robot is not None:
            self._note(self._robot, whole=True)

    def _note(self, robot: Robot, whole: bool = False) -> None:
        """Write the latest readings, once; `whole`: also flush the file."""
        if self._file is None:
            return
        try:
            if robot.time > self._noted:
                self._noted = robot.time
                self._file.write(_row(robot, self._beacons))
            if whole:
                self._file.flush()
        except OSError:
            self.end()

    @override
    def end(self) -> None:
        if self._file is not None:
            with suppress(OSError):
                self._file.close()
        self._file = None


def _row(robot: Robot, beacons: int) -> str:
    """Return a line of the log, with the ranges to a number of beacons."""
    sensed = robot.localization.sensed
    assert sensed is not None
    base = robot.backend.true_base()
    place = (math.nan,) * 3 if sensed.fix is None else (*sensed.fix.position.tolist(), sensed.fix.sigma)
    true = (math.nan,) * 3 if base is None else tuple(base)
    felt = [*sensed.rates.tolist(), *sensed.accelerations.tolist(), *sensed.rolled.tolist()]
    far = [] if not beacons else [math.nan] * beacons if sensed.ranges is None else sensed.ranges.tolist()
    cells = [*_cells(felt, 6), *_cells([*place, *true], PLACE_DIGITS), *_cells(far, 6)]
    return ",".join([f"{robot.time:.4f}", *cells]) + "\n"


def _cells(values: Iterable[float], digits: int) -> list[str]:
    """Return numbers with so many significant digits, and nothing for NaN."""
    return ["" if math.isnan(value) else f"{value:.{digits}g}" for value in values]


def _kept(path: Path, time: float) -> list[str]:
    """Return the lines of a log up to the time in [s] from which its run continues."""
    lines = path.read_text(encoding="utf-8", errors="replace").splitlines(keepends=True)
    table = next((k for k, line in enumerate(lines) if line.startswith("time,")), len(lines) - 1) + 1
    whole = [line for line in lines[table:] if line.endswith("\n")]
    return lines[:table] + [
        line for line in whole if number_in(line.split(",")[0]) < time + TIME_RESOLUTION_S
    ]


def _header(robot: Robot) -> str:
    """Return the YAML header and the line of titles."""
    start, antenna = robot.pose, robot.spec.antenna
    sigma = float(np.sqrt(robot.localization.covariance[2, 2]))
    heading = f", heading_deg: {math.degrees(start.theta):.4f}" if sigma < 1.0 else ""
    columns, beacons = dict(COLUMN_UNITS), list[str]()
    if robot.spec.beacons is not None:
        columns |= {f"range_{name}": "m" for name in robot.spec.beacons.places_m}
        section = robot.spec.beacons.model_dump_json(exclude={"kind"})
        beacons = [f"beacons: {section}"]  # JSON is YAML
    lines = [
        "---",
        "format: handcart-log/1",
        f"start: {{x_m: {start.x:.4f}, y_m: {start.y:.4f}{heading}}}",
        f"antenna_m: [{', '.join(f'{item:.4f}' for item in antenna)}]",
        *beacons,
        "columns:",
        *(f"  {name}: {{unit: {unit}}}" for name, unit in columns.items()),
        "---",
        ",".join(columns),
    ]
    return "\n".join(lines) + "\n"
