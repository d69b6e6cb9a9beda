"""Checks and corrections of a foreign log before it is replayed."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from handcart.evaluation.offline_localization.checks.fix_noise import suppose_noise
from handcart.evaluation.offline_localization.checks.mirror import check_mirror
from handcart.evaluation.offline_localization.checks.mount import axes_rotation, check_mount, mounted
from handcart.evaluation.offline_localization.checks.readings import check_readings
from handcart.evaluation.offline_localization.checks.tilt import without_tilt_drift
from handcart.evaluation.offline_localization.logs.drive_log import DriveLog
from handcart.files.errors import FileError, Finding
from handcart.robotics.navigation.outdoors.field_noise import FieldNoise

AUTO_AXES = "auto"


class PreparedLog(NamedTuple):
    """Log that has been checked and corrected for replay, and the assumed noise of its vehicle."""

    log: DriveLog
    noise: FieldNoise


def prepare(
    path: Path, log: DriveLog, noise: FieldNoise, is_known: bool, imu_axes: str | None
) -> PreparedLog:
    """Check axes and accuracies of a log, and add the findings to its notes.

    Args:
        path: path of the log, named in findings.
        log: the log as read.
        noise: assumed noise of its vehicle.
        is_known: whether `noise` is from the robot's file and is used unchanged.
        imu_axes: the IMU's axes that point forward, left and up; `auto`: the axes are estimated from the log;
            None: they have to be those of the base.

    Raises:
        FileError: the IMU is not mounted in the base's axes, or the given axes are not a frame.
    """
    log = _with_axes(path, log, imu_axes)
    log, contradictions = check_readings(log)
    notes = [*log.notes, *contradictions]
    if not is_known:
        log = without_tilt_drift(log)
        noise, log, more = suppose_noise(log, noise)
        notes += more
    mirrored = check_mirror(log, noise.gps_period)
    notes += [mirrored] if mirrored else []
    return PreparedLog(log._replace(notes=tuple(notes)), noise)


def _with_axes(path: Path, log: DriveLog, imu_axes: str | None) -> DriveLog:
    """Return the log with the IMU's readings in the base's axes."""
    if imu_axes not in (None, AUTO_AXES):
        turned = axes_rotation(imu_axes or "")
        if turned is None:
            allowed = "three different ones of x, y, z, right-handed, with - where one points the other way"
            raise FileError([Finding("--imu-axes", 0, 0, f"{imu_axes!r} is not a frame; allowed: {allowed}")])
        return mounted(log, turned)
    mount = check_mount(log)
    if not mount.words:
        return log
    if imu_axes is None:
        allowed = f"--imu-axes {mount.axes} (forward, left, up) or --imu-axes auto; x,y,z plays it as it is"
        raise FileError([Finding(str(path), 0, 0, f"{mount.words}; allowed: {allowed}")])
    return mounted(log, mount.base_R_imu)._replace(
        notes=(*log.notes, f"{mount.words}; turned to {mount.axes}")
    )
