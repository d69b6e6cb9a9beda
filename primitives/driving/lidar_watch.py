"""Notices while driving that the lidar is blocked, dirty, or sees nothing of what the map shows."""

from __future__ import annotations

import numpy as np

from handcart.backends.capabilities.scan import Scan
from handcart.backends.robot.localization.lidar import MAX_BLIND_SHARE, Lidar
from handcart.backends.robot.robot import Robot
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Measured, NeedsPerson
from handcart.primitives.restoring.snapshot import STALE_S
from handcart.robotics.navigation.maps.expected_echoes import ExpectedEchoes, expected_echoes
from handcart.robotics.navigation.maps.grid_map import GridMap
from handcart.robotics.numerics.arrays import BoolArray

BLOCKED_S = 1.0  # for which most beams show nothing, until the lidar counts as blocked or dirty
LOOK_S = 1.0  # between two comparisons with the map
MAX_SILENT_LOOKS = 2  # comparisons in a row with too few echoes, until it is said
NEAR_SHARE = 0.8  # of the reach, within which a wall of the map must return an echo
MIN_EXPECTED = 20  # beams that must meet a wall of the map, for a comparison
MIN_ECHO_SHARE = 0.15  # of them that must return: walls may be black, glass, hidden, or above the scan plane
FEW_SILENT = (1.0 - MIN_ECHO_SHARE) * MIN_EXPECTED  # beams: no more without an echo are never too many
SECTOR_DEG = 30.0  # of the scan that must show walls which other beams saw before
MAX_SILENT_SHARE = 0.95  # of the sector's beams at such walls that may show nothing
SAME_WALL_M = 0.15  # of an echo from where the map has the wall


class LidarWatch:
    """Monitor that detects a covered, dirty or failed lidar during a drive; called once a period."""

    def __init__(self) -> None:
        self._blind_since: float | None = None
        self._next_look = -1.0
        self._silent_looks = 0
        self._covered_looks = np.zeros(round(360.0 / SECTOR_DEG), dtype=np.int64)
        self._seen = np.empty(0, dtype=np.int64)

    def watch(self, robot: Robot, grid: GridMap | None) -> None:
        """Check the lidar in this period.

        Args:
            robot: robot with the lidar.
            grid: the map, whose walls must return echoes; None: not compared.

        Raises:
            NeedsPerson: the lidar is covered, repeats its last scan, or shows fewer of the map's walls in a
                sector than `MAX_SILENT_SHARE` allows.
        """
        lidar = robot.lidar
        if lidar is None:
            return
        self._watch_blockage(lidar, robot.time)
        if (stale_s := robot.localization.stale_s) > STALE_S:
            age = Measured("RangeSensor", "time since the last new scan", stale_s, STALE_S, "s")
            raise NeedsPerson("the lidar repeats its last scan", age, cause=causes.SENSOR_FAULT)
        if grid is not None and robot.time >= self._next_look:
            self._next_look = robot.time + LOOK_S
            self._compare(lidar, robot, grid)

    def _watch_blockage(self, lidar: Lidar, now: float) -> None:
        blockage = lidar.blockage
        if not blockage:
            self._blind_since = None
            return
        self._blind_since = now if self._blind_since is None else self._blind_since
        if now >= self._blind_since + BLOCKED_S:
            share = Measured(
                "RangeSensor", "share of beams that show nothing", lidar.blind_share, MAX_BLIND_SHARE
            )
            raise NeedsPerson(blockage, share, cause=causes.SENSOR_FAULT)

    def _compare(self, lidar: Lidar, robot: Robot, grid: GridMap) -> None:
        scan = lidar.scan()
        looking = ~lidar.spec.masked(scan.angles)
        returned = np.isfinite(scan.ranges)
        if np.count_nonzero(looking & ~returned) <= FEW_SILENT:
            self._silent_looks = 0
            self._covered_looks[:] = 0
            return
        map_T_sensor = robot.pose.compose(scan.base_T_sensor)
        walls = expected_echoes(grid, map_T_sensor, scan.angles, NEAR_SHARE * lidar.spec.reach_m)
        expected = walls.met & looking
        self._compare_sectors(scan, walls, expected)
        count = int(expected.sum())
        if count < MIN_EXPECTED:
            return
        echoes = int((returned & expected).sum())
        self._silent_looks = 0 if echoes >= MIN_ECHO_SHARE * count else self._silent_looks + 1
        if self._silent_looks >= MAX_SILENT_LOOKS:
            words = f"of {count} beams that meet a wall of the map within its reach {echoes} return"
            raise NeedsPerson(
                f"the lidar gets too few echoes, it is blocked, dirty or mounted wrongly: {words}",
                Measured("RangeSensor", "share of expected echoes", echoes / count, MIN_ECHO_SHARE),
                cause=causes.SENSOR_FAULT,
            )

    def _compare_sectors(self, scan: Scan, walls: ExpectedEchoes, expected: BoolArray) -> None:
        """Raise `NeedsPerson` if a sector of the lidar misses walls that other beams saw.

        Only walls that returned an echo to a beam of this drive count, so objects above the scan plane,
        black surfaces and glass never do. A covered sector is the same in the sensor frame, wherever the
        robot is.

        Args:
            scan: scan of this period, with n beams.
            walls: where the map's walls should return the beams' echoes.
            expected: (n,) True for beams that should return an echo.
        """
        returned = np.isfinite(scan.ranges)
        turned = np.degrees(scan.angles) % 360.0
        sectors = (turned / SECTOR_DEG).astype(np.int64) % len(self._covered_looks)
        known = expected & np.isin(walls.cells, self._seen)
        counts = np.bincount(sectors[known], minlength=len(self._covered_looks))
        silent = np.bincount(sectors[known & ~returned], minlength=len(self._covered_looks))
        covered = silent > MAX_SILENT_SHARE * counts
        looks = np.where(covered, self._covered_looks + 1, 0)
        self._covered_looks = np.where(counts < MIN_EXPECTED, self._covered_looks, looks)
        for sector in np.flatnonzero((self._covered_looks >= MAX_SILENT_LOOKS) & (counts >= MIN_EXPECTED)):
            count, missing = int(counts[sector]), int(silent[sector])
            ends = f"{sector * SECTOR_DEG:.0f} to {(sector + 1) * SECTOR_DEG:.0f} degrees"
            beams_words = f"of {count} beams at walls that it saw before {count - missing} return"
            raise NeedsPerson(
                f"the lidar is covered at {ends}: {beams_words}",
                Measured("RangeSensor", "share of silent beams", missing / count, MAX_SILENT_SHARE),
                cause=causes.SENSOR_FAULT,
            )
        right = np.flatnonzero(expected & returned)
        right = right[np.abs(scan.ranges[right] - walls.ranges[right]) < SAME_WALL_M]
        self._seen = np.union1d(self._seen, walls.cells[right])
