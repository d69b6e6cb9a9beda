"""Before a long drive: whether the sensors will determine the pose at its end at all."""

from __future__ import annotations

from collections.abc import Generator

import numpy as np

from handcart.backends.robot.localization.determination import PoseNeed
from handcart.backends.robot.localization.pose_forecast import PoseForecast, forecast_pose
from handcart.backends.robot.robot import Robot
from handcart.primitives.knowledge.place import Place
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy, Measured
from handcart.robotics.navigation.maps.grid_map import GridMap
from handcart.robotics.navigation.scans.likelihood_field import LikelihoodField
from handcart.robotics.numerics.arrays import FloatArray

from .docking import NOT_DETERMINED

LONG_DRIVE_M = 50.0  # from which it is forecast: a shorter one finds out by driving
HOPELESS_RATIO = 3.0  # of what the place needs: what no map shows, and good wheels, may make up for less


def check_will_be_determined(
    robot: Robot, grid: GridMap, name: str, place: Place, need: PoseNeed, route: FloatArray
) -> Generator[None, None, None]:
    """Raise Discrepancy before a long drive if the pose at the route's end would be far too uncertain.

    The localizer is simulated along the route, with scans computed from the map, as in `handcart check`.
    Short routes are not checked, nor places at which the base docks, which does not need the map.

    Args:
        robot: the robot, at rest at the route's start.
        grid: the map.
        name: name of the place.
        place: place at the route's end.
        need: required accuracy of the pose there.
        route: (n, 2) on the map, in [m].

    Raises:
        Discrepancy: the expected uncertainty of the pose there is `HOPELESS_RATIO` times its limit or more.
    """
    length = float(np.hypot(*np.diff(route, axis=0).T).sum())
    if length < LONG_DRIVE_M or place.docks or robot.spec.localizer != "scan" or not grid.occupied.any():
        return
    forecast: PoseForecast | None = yield from robot.compute(_forecast, robot, grid, need, route)
    found = None if forecast is None else forecast.found
    if forecast is None or found is None or found.size < HOPELESS_RATIO * found.limit:
        return
    size, limit = found.shown
    silent = f", {forecast.silent_m:.0f} m of them without echoes" if forecast.silent_m > 0.0 else ""
    raise Discrepancy(
        f"not determined: at {name}, after {length:.0f} m{silent}, {found.words}, as the map lets expect",
        True,
        Measured(robot.localization.source, "3 sigma of the pose, expected", size, limit, found.unit),
        NOT_DETERMINED,
        cause=causes.UNDETERMINED,
    )


def _forecast(robot: Robot, grid: GridMap, need: PoseNeed, route: FloatArray) -> PoseForecast | None:
    lidar = robot.spec.range_sensor
    if lidar is None:
        return None
    field = robot.localization.map_field or LikelihoodField(grid)
    return forecast_pose(field, robot.spec, lidar, robot.pose, route, need)
