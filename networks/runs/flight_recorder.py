"""The last seconds of readings and commands, kept where something went wrong."""

from __future__ import annotations

import zipfile
from collections import deque
from collections.abc import Mapping, Sequence
from contextlib import suppress
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from typing_extensions import override

from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.base import Base
from handcart.backends.capabilities.gripper import Gripper
from handcart.backends.robot.robot import Robot
from handcart.files.whole_file import write_whole
from handcart.networks.events.events import Ended, Event, Restoring, Started
from handcart.networks.events.run_observer import RunObserver
from handcart.primitives.outcomes.outcome import Success

from .evidence_files import EVIDENCE_FOLDER, stem

MAX_ARRAYS = 256 * 2**20  # bytes
KEPT_TIME_S = 10.0  # of the robot's time
END_STEM = "end"
"""The stem of the file with the run's last seconds."""
READINGS_SUFFIX = "_readings.npz"

Row = dict[str, Any]
Readings = Mapping[str, NDArray[Any]]
"""Columns by name, `time_s` and so on: (n,) or (n, m).

There are constants, too: `footprint_m` (), and of the lidar `angles_rad` (m,) of its beams and
`base_T_sensor` (3,) in [m, m, rad]. In `ranges_m` infinity is a missing return, -infinity too close
and NaN invalid (REP 117).
"""


class FlightRecorder(RunObserver):
    """Recorder of the readings of all sensors but the camera, read once a period.

    At each Fail and GiveUp it writes a file such as `evidence/003_MOVE_TO_Fail_readings.npz`, with the last
    seconds of the failed action's motion, and of its return to the state at its start. At the run's end it
    writes `evidence/end_readings.npz` if there are new readings. Reading a sensor once more in a period gives
    the same values, so recording does not change the run. The arrays' names end in their units.
    """

    def __init__(self, run_dir: Path, robot: Robot, seconds: float = KEPT_TIME_S) -> None:
        """Begin without readings; the last `seconds` of robot time are kept."""
        self._folder = run_dir / EVIDENCE_FOLDER
        self._rows: deque[Row] = deque(maxlen=max(1, round(seconds / robot.period)))
        self._decided: list[Row] = []
        self._same: Row = {"footprint_m": robot.spec.footprint_radius_m}
        if robot.spec.arm is not None:
            self._same["joint_slides"] = np.array(robot.spec.joint_units.slides, dtype=bool)
        self._time = self._kept = -1.0
        self._action, self._restoring = 0, False
        backend = robot.backend
        self._arm, self._gripper = backend.get(Arm), backend.get(Gripper)  # type: ignore[type-abstract]
        self._base, self._range = backend.get(Base), robot.lidar  # type: ignore[type-abstract]
        self.lost: str | None = None
        """Reason why nothing more is kept after the disk refused a write; the run continues."""

    def period(self, robot: Robot) -> None:
        """Record the readings of a control period, except while the robot's time does not pass."""
        if robot.time <= self._time:
            return
        self._time = robot.time
        # The primitive that needs the reading handles a sensor's fault.
        with suppress(Exception):
            self._rows.append(self._read(robot))

    def _read(self, robot: Robot) -> Row:
        pose, sigma = robot.pose, robot.localization.sigma
        row: Row = {
            "time_s": robot.time,
            "action": self._action,
            "restoring": self._restoring,
            "x_m": pose.x,
            "y_m": pose.y,
            "heading_rad": pose.theta,
            "is_located": robot.localization.is_located,
            "position_sigma_m": sigma[0],
            "heading_sigma_rad": sigma[1],
            "scan_explained": robot.localization.explained,
        }
        if self._base is not None:
            travel, command = self._base.wheel_travel(), robot.command
            row["wheel_left_m"], row["wheel_right_m"] = travel.left, travel.right
            row["speed_command_m_s"], row["turn_command_rad_s"] = robot.driven
            if robot.spec.drive.kind == "holonomic":
                row["wheel_sideways_m"], row["sideways_command_m_s"] = travel.sideways, command.sideways
        if self._arm is not None:
            row["joints_rad"], row["joints_command_rad"] = self._arm.joints(), self._arm.command()
            row["hand_force_n"] = self._arm.hand_force()
        if self._gripper is not None:
            row["grip_width_m"], row["grip_command_m"] = self._gripper.width(), self._gripper.command()
            row["grip_presses"] = self._gripper.closed_on_something()
        if self._range is not None:
            row["ranges_m"] = self._range.scan_later()
        return row

    def event(self, event: Event) -> None:
        """Save the readings of the last seconds if the event is a Fail or GiveUp of an action."""
        match event:
            case Started(number=number):
                self._action, self._restoring, self._decided = number, False, []
            case Restoring():
                self._restoring, self._decided = True, list(self._rows)
            case Ended(number=number, action=action, outcome=outcome):
                self._restoring = False
                if not isinstance(outcome, Success):
                    self._keep(stem(number, action.do, outcome))
            case _:
                pass

    @override
    def end(self) -> None:
        self._decided = []
        if self._time > self._kept:
            self._keep(END_STEM)

    def _keep(self, name: str) -> None:
        after = self._decided[-1]["time_s"] if self._decided else -1.0
        rows = [*self._decided, *(row for row in self._rows if row["time_s"] > after)]
        if not rows or self.lost is not None:
            return
        try:
            self._folder.mkdir(exist_ok=True)
            self._scanned(rows)
            packed = BytesIO()
            np.savez_compressed(packed, **_columns(rows), **self._same)
            write_whole(self._folder / f"{name}{READINGS_SUFFIX}", packed.getvalue(), sync=False)
            self._kept = self._time
        except OSError as error:
            self.lost = error.strerror

    def _scanned(self, rows: Sequence[Row]) -> None:
        """Replace the lidar scans of the rows that are kept, which are functions so far, by their values."""
        for row in rows:
            if callable(later := row.get("ranges_m")):
                scan = later()
                self._same["angles_rad"], self._same["base_T_sensor"] = scan.angles, scan.base_T_sensor
                row["ranges_m"] = scan.rep117().round(3).astype(np.float32)


def _columns(rows: Sequence[Row]) -> dict[str, Any]:
    return {name: np.array([row[name] for row in rows]) for name in rows[0]}


def load_arrays(path: Path) -> dict[str, NDArray[Any]]:
    """Return the arrays of an .npz file, by name and of any shape and unit.

    Only numbers are loaded, no Python objects, and at most 256 MiB, which is more than a run ever keeps.

    Raises:
        OSError, ValueError, zipfile.BadZipFile: the file is of another format, damaged, or larger.
    """
    # NumPy leaves a file open that it opened itself and finds damaged.
    with path.open("rb") as file:
        with zipfile.ZipFile(file) as packed:
            size = sum(item.file_size for item in packed.infolist())
        if size > MAX_ARRAYS:
            raise ValueError(f"{size} bytes when unpacked, more than {MAX_ARRAYS}")
        with np.load(file, allow_pickle=False) as arrays:
            return {name: arrays[name] for name in arrays.files}


def load_readings(path: Path) -> Readings:
    """Load the sensor readings that the flight recorder of a run saved as arrays.

    Raises:
        OSError, ValueError, zipfile.BadZipFile: the file cannot be read, is of another format, or damaged.
    """
    columns = load_arrays(path)
    if "time_s" not in columns:
        raise ValueError("the column time_s is missing")
    return columns
