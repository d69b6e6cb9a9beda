"""Reader of scans with odometry in any kind of log."""

from __future__ import annotations

from pathlib import Path

from handcart.evaluation.offline_localization.bags.bag_messages import has_bag_suffix
from handcart.files.errors import FileError, Finding, InputError
from handcart.networks.run_files.run_folder import JOURNAL_FILE
from handcart.robotics.navigation.mapping.scan_log import ScanLog

from .carmen_scans import CARMEN_SUFFIXES, read_carmen
from .csv_scans import read_csv_scans

ALLOWED_SOURCES = (
    "allowed: a run's folder, a ROS bag, a CARMEN log (.log, .clf, also with .gz), a CSV file (.csv)"
)


def read_scans(path: Path, scan_topic: str | None = None) -> ScanLog:
    """Read the scans of a log with its odometry.

    Args:
        path: a run's folder, a ROS bag (file or folder), a CARMEN log, or a CSV file.
        scan_topic: topic of the scans in a ROS bag (default: the topic with the most scans).

    Raises:
        InputError: the log cannot be read, has no range of any beam, its odometry jumps by more than
            `MAX_STEP_M` between two scans, or `scan_topic` is given for another kind of log.
    """
    log = _read(path, scan_topic)
    findings = [Finding(str(path), 0, 0, words) for words in _unusable(log)]
    if findings:
        raise FileError(findings)
    return log


def _read(path: Path, scan_topic: str | None) -> ScanLog:
    if path.is_dir() and (path / JOURNAL_FILE).exists():
        from .run_scans import read_run_scans

        return read_run_scans(path)
    if path.is_dir() or has_bag_suffix(path):
        from .bag_scans import read_bag_scans

        return read_bag_scans(path, scan_topic)
    if scan_topic is not None:
        raise InputError("--scan-topic goes with a ROS bag")
    if path.suffix in CARMEN_SUFFIXES:
        return read_carmen(path)
    if path.suffix == ".csv" or not path.exists():
        return read_csv_scans(path)
    raise FileError([Finding(str(path), 0, 0, f"no kind of log is named {path.suffix!r}; {ALLOWED_SOURCES}")])


def _unusable(log: ScanLog) -> list[str]:
    """Return why no map can be made of a log; empty if one can."""
    import numpy as np

    wrong = list[str]()
    if not np.isfinite(log.ranges).any():
        wrong.append("no beam of any scan hit anything; needed: ranges")
    steps = np.hypot(*np.diff(log.odometry[:, :2], axis=0).T)
    if steps.max(initial=0.0) > MAX_STEP_M:
        row = int(np.argmax(steps)) + 1
        at = log.times[row] - log.times[0]
        wrong.append(
            f"the odometry jumps by {steps[row - 1]:.1f} m between two scans, {at:.1f} s after the first; "
            f"allowed: at most {MAX_STEP_M:g} m"
        )
    return wrong


MAX_STEP_M = 10.0
"""Distance between two scans beyond which they have nothing in common."""
