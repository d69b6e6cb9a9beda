"""The lidar of a robot, its scans read by the robot's file."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from typing_extensions import override

from handcart.backends.backend import Backend
from handcart.backends.capabilities.range_sensor import RangeSensor
from handcart.backends.capabilities.scan import Scan, Validity
from handcart.backends.description.range_spec import RangeSpec
from handcart.backends.description.robot_file import RobotFile
from handcart.robotics.navigation.scans.start_search import ScanBeams

from .scan_reading import read_scan

MAX_BLIND_SHARE = 0.5
"""Share of a scan's beams that may be too close or invalid; beyond it the lidar is blocked or dirty."""
MIN_ECHOES = 20
"""Minimum number of returns in a scan; with fewer the lidar hardly sees anything."""
ANY_LIDAR = RangeSpec(beams=3, reach_m=1e6, sigma_mm=10.0)


class Lidar(RangeSensor):
    """Wrapper of a backend's lidar that interprets its raw scans by the robot's file.

    In an interpreted scan each beam has a `Validity`. All code except the backends uses interpreted scans.
    """

    def __init__(self, sensor: RangeSensor, robot: RobotFile, spec: RangeSpec | None = None) -> None:
        """Read a sensor's scans by its section of a robot's file (default: that of the first lidar)."""
        self._sensor, self._footprint = sensor, robot.footprint_shape
        self.sensor_name = sensor.sensor_name
        self.spec = spec or robot.range_sensor or ANY_LIDAR
        """The lidar's section of the robot's file; without limits there, any reading counts as a return."""
        self._raw: Scan | None = None
        self._read: Scan | None = None
        self._blind: tuple[Scan, float] | None = None
        self._silence: tuple[Scan, str] | None = None
        self._beams: tuple[Scan, ScanBeams] | None = None

    def scan(self) -> Scan:
        """Return this period's scan, in which each beam has its validity."""
        raw = self._sensor.scan()
        if self._read is None or raw is not self._raw:
            self._raw, self._read = raw, self.read(raw)
        return self._read

    @override
    def scan_later(self) -> Callable[[], Scan]:
        later = self._sensor.scan_later()
        return lambda: self.read(later())

    def read(self, raw: Scan) -> Scan:
        """Interpret a raw scan: give each beam its validity, and set ranges without a return to infinity."""
        return read_scan(raw, self.spec, self._footprint)

    @property
    def blockage(self) -> str:
        """Message that the lidar is blocked or dirty; "" if it is not.

        A lidar counts as blocked if more than half of this period's beams give no reading, or end within its
        shortest range or the robot's outline.
        """
        if self.blind_share <= MAX_BLIND_SHARE:
            return ""
        scan = self.scan()
        looking = ~self.spec.masked(scan.angles)
        close = int((scan.validity[looking] == Validity.TOO_CLOSE).sum())
        invalid = int((scan.validity[looking] == Validity.INVALID).sum())
        beams = f"of {int(looking.sum())} beams {close} are too close and {invalid} give no reading"
        return f"the lidar is blocked or dirty: {beams}"

    @property
    def blind_share(self) -> float:
        """Share (0 to 1) of this period's beams, except masked beams, that are too close or invalid."""
        scan = self.scan()
        if self._blind is None or self._blind[0] is not scan:
            self._blind = scan, self._blind_share(scan)
        return self._blind[1]

    def _blind_share(self, scan: Scan) -> float:
        blind = scan.blind()
        if self.spec.masked_deg:
            blind = blind[~self.spec.masked(scan.angles)]
        return np.count_nonzero(blind) / len(blind) if len(blind) else 1.0

    @property
    def silence(self) -> str:
        """Message that this period's scan is useless for localization; "" if it can be used.

        A scan is useless if the lidar is blocked (`blockage`) or gets fewer than `MIN_ECHOES` echoes.
        """
        scan = self.scan()
        if self._silence is None or self._silence[0] is not scan:
            self._silence = scan, self._silence_of(scan)
        return self._silence[1]

    def _silence_of(self, scan: Scan) -> str:
        echoes = int(np.count_nonzero(np.isfinite(scan.ranges)))
        blockage = self.blockage
        if blockage or echoes >= min(MIN_ECHOES, len(scan.ranges)):
            return blockage
        return f"the lidar gets next to no echoes: {echoes} of {len(scan.ranges)} beams return"

    def beams(self) -> ScanBeams:
        """Return this period's scan as beams in the base frame; ranges are NaN for beams that show neither an
        obstacle nor free ground.

        All callers get the same arrays, and must not change them.
        """
        scan = self.scan()
        if self._beams is None or self._beams[0] is not scan:
            self._beams = scan, _beams_of(scan, self.spec.reach_m)
        return self._beams[1]


def beams_of(lidar: Lidar) -> ScanBeams:
    """Return this period's scan as beams in the base frame; ranges are NaN for beams that show neither an
    obstacle nor free ground.
    """
    return lidar.beams()


def _beams_of(scan: Scan, reach: float) -> ScanBeams:
    sensor = scan.base_T_sensor
    ranges = np.where(scan.blind(), np.nan, scan.ranges) if len(scan.validity) else scan.ranges
    return ScanBeams(np.array([sensor.x, sensor.y]), scan.angles + sensor.theta, ranges, reach)


def other_lidars(backend: Backend, spec: RobotFile, first: RangeSensor | None) -> Iterator[Lidar]:
    """Yield the lidars of a robot besides the first one, in the order of the backend's capabilities.

    Args:
        backend: backend of the robot.
        spec: robot file.
        first: sensor of the first lidar, which is left out; None: the robot has no lidar.
    """
    for capability in backend.capabilities():
        section = spec.sensors.get(capability.sensor_name)
        if isinstance(capability, RangeSensor) and capability is not first and isinstance(section, RangeSpec):
            yield Lidar(capability, spec, section)
