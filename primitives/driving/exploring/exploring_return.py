"""The way back of EXPLORE: over its own map to the start, which is found again by a scan."""

from __future__ import annotations

import math

import numpy as np

from handcart.backends.robot.robot import Robot
from handcart.primitives.contract.action_primitive import Periods
from handcart.primitives.driving.scan_collector import ScanCollector
from handcart.primitives.knowledge.world_model import ModelView
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy, Measured
from handcart.primitives.restoring.retrace import reach_pose
from handcart.primitives.restoring.return_progress import HELD_RETURN_S
from handcart.primitives.restoring.snapshot import Snapshot, settle
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.mapping.line_matching import match_surfaces
from handcart.robotics.navigation.mapping.scan_surface import Surface
from handcart.robotics.navigation.mapping.window_search import search_window
from handcart.robotics.navigation.maps.grid_map import GridMap
from handcart.robotics.navigation.scans.likelihood_field import LikelihoodField

from .exploring_drive import START_NAME, ExploringDrive
from .exploring_look import ExploringLook
from .map_work import MapWork

WAIT_S = 30.0  # for a passer-by on the way back
CLOSE_M = 0.4  # of the start, from where no route is planned
START_CELL_M = 0.02
WINDOW_M, WINDOW_RAD = 0.8, 0.5  # in which the start is looked for
MIN_INLIERS = 0.5  # share of the scan that the first keyframes must explain
MARGIN_M = 1.0  # of map around it
NEAR_RATIO = 0.3  # of the tolerance, within which the base stays as it is
MAX_LOOKS = 3  # scans at rest, each followed by a correction


def drive_to_start(
    robot: Robot,
    model: ModelView,
    start: Snapshot,
    scans: ScanCollector,
    work: MapWork,
    look: ExploringLook,
) -> Periods:
    """Bring the base back to the pose of the first keyframe, and check its pose by a scan at rest.

    Args:
        robot: the robot.
        model: world model.
        start: snapshot of the robot at the start.
        scans: collector of scans, with the growing map.
        work: computations on that map.
        look: choice of frontiers, which draws the map.

    Raises:
        Discrepancy: no route leads back, or the scan at rest does not match the scans that were taken at the
            start.
    """
    first = scans.map.poses[0]
    found = yield from work.run(robot, look.take, scans.pose, None)
    robot.localization.follow_map(found.field, scans.pose, found.covariance)
    if scans.pose.distance(first) > CLOSE_M:
        drive = ExploringDrive(model, found.grid, first, WAIT_S, START_NAME)
        yield from drive.periods(robot)
    for _ in range(MAX_LOOKS):
        yield from settle(robot)
        yield from _measure_start(robot, scans)
        if _is_near(robot, start.pose):
            break
        yield from reach_pose(robot, start.pose, held_s=HELD_RETURN_S)
    yield from settle(robot)
    yield from _measure_start(robot, scans)


def _is_near(robot: Robot, goal: Pose2) -> bool:
    """Return whether the base is well within its tolerance of a pose."""
    tolerance = robot.spec.tolerance
    near = robot.pose.distance(goal) < NEAR_RATIO * tolerance.base_mm / 1e3
    return near and robot.pose.turn(goal) < NEAR_RATIO * math.radians(tolerance.base_deg)


def _measure_start(robot: Robot, scans: ScanCollector) -> Periods:
    """Correct the pose by a scan at rest, matched with those of the start."""
    first, reference, here = scans.map.poses[0], scans.map.start_surface, scans.look().surface
    guess = scans.pose.relative_to(first)
    near = search_window(reference.points, here.points, guess, WINDOW_M, WINDOW_RAD)
    tried = [
        match_surfaces(reference, here, pose) for pose in (guess, *(hypothesis.pose for hypothesis in near))
    ]
    best = max(tried, key=lambda match: match.inliers)
    if best.inliers < MIN_INLIERS:
        raise Discrepancy(
            "the scan does not fit those of the start",
            measured=Measured("RangeSensor", "share of the scan that fits", best.inliers, MIN_INLIERS),
            cause=causes.LOST,
        )
    covariance = np.asarray(np.linalg.inv(best.information + 1e-6 * np.eye(3)), dtype=np.float64)
    robot.localization.follow_map(_field(first, reference), first.compose(best.pose), covariance)
    robot.localization.measure_displacement(best.pose, covariance)
    scans.found_at(best.pose)
    yield


def _field(first: Pose2, surface: Surface) -> LikelihoodField:
    """Return the likelihood field, on the drawn map, of a surface given in the frame of the first keyframe's
    pose.
    """
    points = first.apply(surface.points)
    low, high = points.min(axis=0) - MARGIN_M, points.max(axis=0) + MARGIN_M
    columns, rows = np.ceil((high - low) / START_CELL_M).astype(np.int64).tolist()
    nothing = np.zeros((rows, columns), dtype=np.bool_)
    grid = GridMap(nothing, nothing.copy(), START_CELL_M, float(low[0]), float(low[1]))
    return LikelihoodField(grid.with_points(points), is_drawn=True)
