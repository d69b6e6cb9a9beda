"""Reader of CARMEN logs, in which most public data sets of two-dimensional lidars are."""

from __future__ import annotations

import gzip
import math
import zlib
from collections import Counter
from pathlib import Path
from typing import NamedTuple

import numpy as np

from handcart.files.csv_table import number_in
from handcart.files.errors import FileError, Finding
from handcart.files.findings import Findings
from handcart.files.regular_file import decode_text, read_regular_file
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.mapping.scan_log import ScanLog
from handcart.robotics.numerics.arrays import FloatArray

from .odometry_track import poses_at

CARMEN_SUFFIXES = (".log", ".clf", ".carmen", ".gz")
MAX_BYTES = 1 << 29
MAX_SHOWN_LINES = 10
DEFAULT_REACH_M = 40.0
"""Range from which on a reading counts as no echo in logs that state no reach; SICK's write 81.83."""
MAX_BEAMS = 10_000
CENTRED_MOUNT = Pose2(0.0, 0.0, 0.0)
MAX_MOUNT_M = 2.0
"""Distance between laser and robot pose in a line from which on they are not used as the mounting, because
only the laser's pose was corrected."""
AFTER_RANGES = 9
"""Number of words behind the ranges in a FLASER line."""


class _Scans(NamedTuple):
    """Content of the lines of a log."""

    scans: list[tuple[FloatArray, float, float, float]]
    """Ranges in [m], angle of the first beam and field of view in [rad], and reach in [m] of each scan."""
    times: list[float]
    poses: list[tuple[float, ...]]
    """Odometry pose in each scan's line, as x, y in [m] and heading in [rad]."""
    track: list[tuple[float, ...]]
    """x, y in [m], heading in [rad] and time in [s] of each ODOM line."""
    mounts: list[Pose2]
    """Mounting of the lidar on the base by each scan's line."""


def read_carmen(path: Path) -> ScanLog:
    """Read the scans of a CARMEN log (FLASER or ROBOTLASER1), with its odometry.

    If the log has ODOM lines, the odometry is read from them: in corrected logs, the lines of the scans have
    the result of an earlier mapping instead of the odometry.

    Raises:
        FileError: the file has no scans, or lines that cannot be read; it lists the first such lines.
    """
    found, findings = _Scans([], [], [], [], []), Findings()
    for number, line in enumerate(_text(path).splitlines(), start=1):
        words = line.split()
        if not words or words[0] not in _LINE_READERS:
            continue
        wrong = _LINE_READERS[words[0]](words, found)
        if wrong:
            findings.add(Finding(str(path), number, 1, f"{words[0]}: {wrong}"))
        if len(findings) >= MAX_SHOWN_LINES:
            break
    findings.raise_all()
    if len(found.scans) < 2:
        wrong = f"{len(found.scans)} scans in it; needed: at least two lines FLASER or ROBOTLASER1"
        raise FileError([Finding(str(path), 1, 1, wrong)])
    return _log(path, found)


def _text(path: Path) -> str:
    content = read_regular_file(path, MAX_BYTES)
    if content[:2] == b"\x1f\x8b":
        try:
            unpacked = zlib.decompressobj(16 + zlib.MAX_WBITS).decompress(content, MAX_BYTES)
        except (zlib.error, gzip.BadGzipFile) as error:
            wrong = (
                f"no gzip file that can be unpacked: {error}; allowed: a CARMEN log, or one packed with gzip"
            )
            raise FileError([Finding(str(path), 1, 1, wrong)]) from None
        content = unpacked
    return decode_text(content, str(path), longest_line=None)


def _numbers(words: list[str]) -> list[float]:
    return [number_in(word) for word in words]


def _flaser(words: list[str], found: _Scans) -> str:
    """Parse a line of a scan, and return its fault; empty if it has none.

    FLASER count [range_reading]* x y theta odom_x odom_y odom_theta ipc_time host logger_time.
    """
    count = number_in(words[1]) if len(words) > 1 else math.nan
    if not 2.0 <= count <= MAX_BEAMS or count % 1.0:
        return f"no number of readings; allowed: 2 to {MAX_BEAMS}"
    beams = int(count)
    if len(words) < 2 + beams + AFTER_RANGES:
        return f"{len(words)} words; needed: {2 + beams + AFTER_RANGES} for {beams} readings"
    values = _numbers(words[2 : 2 + beams + 7])
    if not np.isfinite(values).all():
        return "a word is no number; allowed: decimal numbers"
    step = math.pi / 180.0 if beams < 200 else math.pi / (180.0 * round(beams / 180.0))
    width = step * (beams - 1)
    found.scans.append((np.array(values[:beams]), -0.5 * width, width, DEFAULT_REACH_M))
    found.poses.append(tuple(values[beams + 3 : beams + 6]))
    found.mounts.append(CENTRED_MOUNT)
    found.times.append(values[beams + 6])
    return ""


def _robot_laser(words: list[str], found: _Scans) -> str:
    """Parse a line of a scan with remissions, and return its fault; empty if it has none.

    ROBOTLASER1 type start_angle field_of_view resolution reach accuracy remission count ranges ...

    Behind the ranges: count of remissions, remissions, laser pose, robot pose, five limits, three times.
    """
    values = _numbers(words[1:9])
    if len(values) < 8 or not np.isfinite(values).all() or not 2.0 <= values[7] <= MAX_BEAMS:
        return f"no number of readings; allowed: 2 to {MAX_BEAMS}"
    beams = int(values[7])
    remissions = number_in(words[9 + beams]) if len(words) > 9 + beams else math.nan
    after = 10 + beams + (int(remissions) if 0 <= remissions <= MAX_BEAMS else 0)
    if len(words) < after + 12 or not math.isfinite(remissions):
        return f"{len(words)} words; needed: {after + 12}"
    ranges, rest = _numbers(words[9 : 9 + beams]), _numbers(words[after : after + 12])
    if not np.isfinite([*ranges, *rest]).all():
        return "a word is no number; allowed: decimal numbers"
    found.scans.append((np.array(ranges), values[1], values[2], min(values[4], DEFAULT_REACH_M)))
    found.poses.append(tuple(rest[3:6]))
    mount = Pose2(*rest[:3]).relative_to(Pose2(*rest[3:6]))
    found.mounts.append(mount if mount.distance(CENTRED_MOUNT) < MAX_MOUNT_M else CENTRED_MOUNT)
    found.times.append(rest[11])
    return ""


def _odom(words: list[str], found: _Scans) -> str:
    """Parse a line of odometry, and return its fault; empty if it has none.

    ODOM x y theta tv rv accel ipc_time host logger_time.
    """
    values = _numbers([*words[1:4], *words[7:8]])
    if len(values) < 4 or not np.isfinite(values).all():
        return "a word is missing or no number; needed: x y theta tv rv accel time"
    found.track.append(tuple(values))
    return ""


_LINE_READERS = {"FLASER": _flaser, "ROBOTLASER1": _robot_laser, "ODOM": _odom}


def _log(path: Path, found: _Scans) -> ScanLog:
    times, odometry = np.array(found.times), np.array(found.poses)
    shapes = Counter((len(ranges), start, width) for ranges, start, width, _ in found.scans)
    (beams, start, width), usual = shapes.most_common(1)[0]
    notes = list[str]()
    used = np.array([(len(r), s, w) == (beams, start, width) for r, s, w, _ in found.scans])
    if usual < len(found.scans):
        notes.append(f"{len(found.scans) - usual} scans have other beams than most; they are skipped")
    if len(found.track) > 1:
        track = np.array(found.track)
        odometry, near = poses_at(times, track[:, 3], track[:, :3])
        if not near[used].all():
            notes.append(
                f"{int((~near[used]).sum())} scans have no odometry within a second; they are skipped"
            )
        used &= near
    rising = np.flatnonzero(used)[np.argsort(times[used], kind="stable")]
    if len(rising) < 2:
        wrong = "no two scans with odometry; needed: ODOM lines at the times of the scans"
        raise FileError([Finding(str(path), 1, 1, wrong)])
    reach = found.scans[rising[0]][3]
    ranges = np.array([found.scans[row][0] for row in rising])
    ranges[(ranges >= reach) | (ranges <= 0.0)] = math.nan
    angles = start + width * np.arange(beams) / (beams - 1)
    mount = found.mounts[rising[0]]
    return ScanLog(times[rising], odometry[rising], angles, ranges, mount, reach, tuple(notes))
