"""Choice of the next place to look from, which separates the hypotheses of the pose.

The base stays on ground that the lidar has seen to be free. Among the places there, one is chosen from
where the map predicts different scans for different hypotheses (Fox, Burgard and Thrun, 1998), or from
where ground becomes visible that was not seen yet.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import cv2
import numpy as np

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.maps.grid_map import GridMap
from handcart.robotics.navigation.routes.ways import Ways
from handcart.robotics.navigation.scans.likelihood_field import LikelihoodField
from handcart.robotics.navigation.scans.start_search import map_ranges
from handcart.robotics.numerics.arrays import BoolArray, FloatArray

MARGIN_M = 0.05  # beside the footprint, from anything that was not seen to be free
MAX_AWAY_M, MIN_AWAY_M = 6.0, 0.5  # of a place from the base
GRID_M = 0.4  # between places that are compared
TRIED_M = 0.6  # from earlier places, within which none is chosen again
MAX_COMPARED = 6  # hypotheses
PREDICTED_BEAMS = 48
DIFFERENT_M = 0.3  # between predicted ranges that a scan can distinguish
NOVELTY_RADIUS_M = 2.0
NOVELTY_WEIGHT = 0.3  # of the share of unseen ground around, against the share of beams that differ
WAY_WEIGHT_PER_M = 0.03
MAX_ALIKE = 150  # places in the test whether the map looks the same from everywhere
MIN_DIFFERENCE = 0.05  # share of beams that differ where a scan can separate two hypotheses
MAX_ROUTES = 8  # places to which a route is looked for


class View(NamedTuple):
    """Place to which a base should drive for another scan, which distinguishes hypotheses of its pose."""

    route: FloatArray
    """(n, 2) points from the base to it, in the local frame, in [m]."""
    difference: float
    """Mean share of beams, 0 to 1, by which the other hypotheses would differ from the best one there."""


class Surroundings(NamedTuple):
    """Ground sensed around the base, in which a place for another scan is searched."""

    seen: GridMap
    """Map in the local frame; ground that was not seen is unknown."""
    here: Pose2
    """local_T_base."""
    radius: float
    """Radius of the footprint, in [m]."""
    tried: FloatArray
    """(n, 2) places in the local frame that were looked from, in [m]."""


def next_view(around: Surroundings, field: LikelihoodField, poses: FloatArray, reach: float) -> View | None:
    """Return the next place for a scan that distinguishes the hypotheses of the base's pose; None without
    one.

    The place is 0.5 to 6 m away.

    Args:
        around: ground that the robot has sensed around it.
        field: likelihood field of the map.
        poses: (k, 3) map_T_base of each hypothesis, in [m, m, rad], the best first.
        reach: range of the lidar, in [m].
    """
    places = _reachable(around)
    if not len(places):
        return None
    difference = predicted_difference(around.here, places, field, poses[:MAX_COMPARED], reach)
    away = np.hypot(*(places - (around.here.x, around.here.y)).T)
    gain = difference + NOVELTY_WEIGHT * _novelty(around.seen, places) - WAY_WEIGHT_PER_M * away
    gain = np.where(_is_blocked(around, places, field, poses[:MAX_COMPARED]), -np.inf, gain)
    ways = Ways(around.seen, around.radius, around.here)
    for number in np.argsort(-gain, kind="stable")[:MAX_ROUTES]:
        if math.isinf(gain[number]):
            return None
        route = ways.to((float(places[number, 0]), float(places[number, 1]))).route
        if route is not None and route.length <= 2.0 * MAX_AWAY_M:
            return View(route.points, float(difference[number]))
    return None


def predicted_difference(
    here: Pose2, places: FloatArray, field: LikelihoodField, poses: FloatArray, reach: float
) -> FloatArray:
    """Return how well a scan would separate the best hypothesis from the others, at each place.

    Two ranges count as different if they differ by more than `DIFFERENT_M`. With a single hypothesis all
    values are 0.

    Args:
        here: present local_T_base; each of `poses` is a hypothesis for map_T_base at the same moment.
        places: (n, 2) in the local frame, in [m].
        field: likelihood field of the map.
        poses: (k, 3) map_T_base of each hypothesis, in [m, m, rad], the best first.
        reach: largest range of the lidar, in [m].

    Returns:
        (n,) mean share of beams whose ranges would differ, from 0 to 1.
    """
    if len(poses) < 2:
        return np.zeros(len(places))
    angles = np.linspace(-math.pi, math.pi, PREDICTED_BEAMS, endpoint=False)
    shares = np.zeros(len(places))
    steps = here.inverse().apply(places)
    for number, (x, y) in enumerate(steps.tolist()):
        ranges = [
            map_ranges(field, Pose2(*pose).compose(Pose2(x, y, 0.0)), angles, reach)
            for pose in poses.tolist()
        ]
        capped = np.minimum(np.array(ranges), reach)
        differs = np.abs(capped[1:] - capped[0]) > DIFFERENT_M
        shares[number] = float(differs.mean())
    return shares


def look_alike(field: LikelihoodField, poses: FloatArray, radius: float, within: float, reach: float) -> bool:
    """Return True if no scan from a near place could distinguish the best hypothesis from another hypothesis.

    The map then looks the same around both hypotheses.

    Args:
        field: likelihood field of the map.
        poses: (k, 3) map_T_base of each hypothesis, in [m, m, rad], the best first.
        radius: radius of the footprint, in [m].
        within: largest distance of the places from the base, in [m].
        reach: largest range of the lidar, in [m].
    """
    here = Pose2(*poses[0].tolist())
    places = _reachable(Surroundings(field.map, here, radius, np.empty((0, 2))), within)
    if not len(places):
        return False
    every = max(1, len(places) // MAX_ALIKE)
    for pose in poses[1 : 1 + MAX_COMPARED]:
        differs = predicted_difference(here, places[::every], field, np.array([poses[0], pose]), reach)
        if differs.max() < MIN_DIFFERENCE:
            return True
    return False


def _reachable(around: Surroundings, within: float = MAX_AWAY_M) -> FloatArray:
    """Return (n, 2) places on connected ground that was seen to be free, with room for the footprint, in
    [m].
    """
    seen = around.seen
    clear = cv2.distanceTransform((~seen.blocked).astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    room = (clear * seen.resolution > around.radius + MARGIN_M).astype(np.uint8)
    labels = cv2.connectedComponents(room)[1]
    row, column = seen.to_cell(np.array([[around.here.x, around.here.y]]))[0].tolist()
    size = math.ceil((around.radius + MARGIN_M) / seen.resolution)
    low = max(0, row - size), max(0, column - size)
    near = labels[low[0] : row + size + 1, low[1] : column + size + 1]
    if not (near > 0).any():
        return np.empty((0, 2))
    offsets = np.argwhere(near > 0)
    nearest = offsets[np.argmin(np.hypot(*(offsets + low - (row, column)).T))]
    every = max(1, round(GRID_M / seen.resolution))
    cells = np.argwhere(labels[::every, ::every] == near[tuple(nearest)]) * every
    places = seen.to_point(cells)
    away = np.hypot(*(places - (around.here.x, around.here.y)).T)
    fits = (away >= MIN_AWAY_M) & (away <= within)
    for tried in around.tried:
        fits &= np.hypot(*(places - tried).T) > TRIED_M
    return np.asarray(places[fits])


def _novelty(seen: GridMap, places: FloatArray) -> FloatArray:
    """Return (n,) share of ground around places (n, 2) that was not seen."""
    size = 2 * round(NOVELTY_RADIUS_M / seen.resolution) + 1
    unseen = cv2.blur(seen.unknown.astype(np.float32), (size, size), borderType=cv2.BORDER_REPLICATE)
    rows, columns = seen.to_cell(places).T
    return np.asarray(unseen[rows, columns], dtype=np.float64)


def _is_blocked(
    around: Surroundings, places: FloatArray, field: LikelihoodField, poses: FloatArray
) -> BoolArray:
    """Return (n,) True where the map shows something at a place, as one of the hypotheses has it."""
    steps = around.here.inverse().apply(places)
    blocked = np.zeros(len(places), dtype=np.bool_)
    grid = field.map
    for pose in poses.tolist():
        there = Pose2(*pose).apply(steps)
        inside = grid.inside(there)
        rows, columns = grid.to_cell(there[inside]).T
        blocked[inside] |= grid.blocked[rows, columns]
        blocked |= field.read(there) < around.radius
    return blocked
