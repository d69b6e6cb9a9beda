"""Notices while driving that the lidar is blocked, dirty, or sees nothing of what the map shows."""

from __future__ import annotations

import numpy as np

from handcart.backends.robot.lidar import MAX_BLIND_SHARE, Lidar
from handcart.backends.robot.robot import Robot
from handcart.primitives.contract.discrepancy import Measured, NeedsPerson
from handcart.robotics.navigation.maps.expected_echoes import expected_echoes
from handcart.robotics.navigation.maps.grid_map import GridMap

BLOCKED_S = 1.0  # for which most beams show nothing, until the lidar counts as blocked or dirty
LOOK_S = 1.0  # between two comparisons with the map
LOOKS = 2  # comparisons in a row with too few echoes, until it is said
NEAR_SHARE = 0.8  # of the reach, within which a wall of the map must return an echo
MIN_EXPECTED = 20  # beams that must meet a wall of the map, for a comparison
MIN_ECHO_SHARE = 0.15  # of them that must return: walls may be black, glass, hidden, or above the scan plane
FEW_SILENT = (1.0 - MIN_ECHO_SHARE) * MIN_EXPECTED  # beams: no more without an echo are never too many


class LidarWatch:
    """Watches the beams of one drive; asked once a period."""

    def __init__(self) -> None:
        self._blind_since: float | None = None
        self._next_look = -1.0
        self._silent_looks = 0

    def watch(self, robot: Robot, grid: GridMap | None) -> None:
        """Raise `NeedsPerson` where the lidar has shown next to nothing for a while.

        Args:
            robot: whose lidar it is.
            grid: the map, if there is one: its walls must return echoes.
        """
        lidar = robot.lidar
        if lidar is None:
            return
        self._watch_blockage(lidar, robot.time)
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
            raise NeedsPerson(blockage, share)

    def _compare(self, lidar: Lidar, robot: Robot, grid: GridMap) -> None:
        scan = lidar.scan()
        looking = ~lidar.spec.masked(scan.angles)
        returned = np.isfinite(scan.ranges)
        if np.count_nonzero(looking & ~returned) <= FEW_SILENT:
            self._silent_looks = 0
            return
        map_T_sensor = robot.pose.compose(scan.base_T_sensor)
        expected = expected_echoes(grid, map_T_sensor, scan.angles, NEAR_SHARE * lidar.spec.reach_m)
        expected &= looking
        count = int(expected.sum())
        if count < MIN_EXPECTED:
            return
        echoes = int((returned & expected).sum())
        self._silent_looks = 0 if echoes >= MIN_ECHO_SHARE * count else self._silent_looks + 1
        if self._silent_looks >= LOOKS:
            walls = f"of {count} beams that meet a wall of the map within its reach {echoes} return"
            raise NeedsPerson(
                f"the lidar gets too few echoes, it is blocked, dirty or mounted wrongly: {walls}",
                Measured("RangeSensor", "share of expected echoes", echoes / count, MIN_ECHO_SHARE),
            )
