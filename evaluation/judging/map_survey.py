"""Check by ground truth that a map which EXPLORE drew is complete, and that its walls are where they are."""

from __future__ import annotations

from typing import ClassVar, NamedTuple

import cv2
import numpy as np
from typing_extensions import override

from handcart.primitives.contract.action_primitive import ActionPrimitive
from handcart.primitives.outcomes.drawn_map import DrawnMap
from handcart.primitives.outcomes.outcome import Outcome, Success
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.mapping.box_walls import BoxWalls, compare_with_boxes, surface_distances
from handcart.robotics.navigation.maps.grid_map import GridMap, from_boxes
from handcart.robotics.numerics.arrays import FloatArray

from .at_most import at_most
from .survey import Claim, FiguresSurvey, Survey, SurveyedRun

EXPLORE_NAME = "EXPLORE"
MAX_WALL_MEDIAN_MM, MAX_WALL_95_MM = 50.0, 150.0  # fixed limits of the walls that EXPLORE claims to know
MIN_MAPPED_PERCENT = 95.0  # of the floor that the robot can reach
MAX_MISSING_PERCENT = 5.0  # of the walls beside floor that the map shows as free
FLOOR_CELL_M = 0.1
FLOOR_MARGIN_M = 1.0
FLOOR_ROOM_M = 0.12  # added to the footprint, for floor that the robot can certainly reach


class MapFigures(NamedTuple):
    """Errors of a map's walls against the simulated world, and what of the floor and walls the map shows."""

    walls_mm: FloatArray
    """(n,) distance of each occupied cell to the nearest true surface, in [mm]."""
    mapped_percent: float
    """Share of the reachable floor that the map shows; NaN for a world without outer walls."""
    missing_percent: float
    """Share of the true walls, where they border on floor that the map shows as free, that it lacks."""


def compare_with_world(run: SurveyedRun, drawn: DrawnMap, radius_m: float) -> MapFigures:
    """Return the errors of a map's walls, and the share of the floor mapped, by the simulated world; the
    share is NaN without outer walls.

    Args:
        run: run with the simulated world and the robot.
        drawn: the map.
        radius_m: distance from the start within which the floor had to be mapped.
    """
    height = run.robot.range_sensor_height
    boxes = [solid.outline for solid in run.world.solids if solid.reaches(height)]
    cells = run.world_T_map.apply(drawn.grid.to_point(np.argwhere(drawn.grid.occupied)))
    walls = 1e3 * surface_distances(cells, boxes)
    missing = _missing_percent(compare_with_boxes(drawn.grid, boxes, run.world_T_map.inverse()))
    first = run.world_T_map.compose(Pose2(*drawn.built.poses[0].tolist()))
    floor = reachable_floor(boxes, run.robot.spec.footprint_shape.inscribed, first)
    floor = floor[np.hypot(*(floor - first[:2]).T) < radius_m - FLOOR_MARGIN_M]
    if not len(floor):
        return MapFigures(walls, float("nan"), missing)
    known = _is_known(drawn.grid, run.world_T_map.inverse().apply(floor))
    return MapFigures(walls, 100.0 * float(known.mean()), missing)


def _missing_percent(found: BoxWalls) -> float:
    """Return the share of all boxes' visible outlines that a map lacks, in percent; 0 if none is visible."""
    seen = np.array(found.visible)
    return 100.0 * float(seen @ found.missing) / max(float(seen.sum()), 1e-9)


def reachable_floor(
    boxes: list[tuple[float, float, float, float, float]], radius: float, start: Pose2
) -> FloatArray:
    """Return points (n, 2) of a grid, in [m], that a disc's middle can reach without touching obstacles.

    They are in the frame of the boxes. The result is empty without outer walls around the start, because the
    disc could then leave the area of the boxes.

    Args:
        boxes: x, y of the middle in [m], yaw in [rad], length and width in [m] of each obstacle.
        radius: radius of the disc, in [m].
        start: pose of the disc in the frame of the boxes.
    """
    if not boxes:
        return np.empty((0, 2))
    reach = np.array(
        [
            [x - 0.5 * (a + b), y - 0.5 * (a + b), x + 0.5 * (a + b), y + 0.5 * (a + b)]
            for x, y, _, a, b in boxes
        ]
    )
    low, high = reach[:, :2].min(axis=0) - FLOOR_MARGIN_M, reach[:, 2:].max(axis=0) + FLOOR_MARGIN_M
    grid = from_boxes(boxes, FLOOR_CELL_M, (float(low[0]), float(low[1])), tuple((high - low).tolist()))
    clear = cv2.distanceTransform((~grid.occupied).astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    _, labels = cv2.connectedComponents((clear * FLOOR_CELL_M > radius + FLOOR_ROOM_M).astype(np.uint8))
    open_ = np.argwhere(labels > 0)
    here = open_[np.argmin(np.hypot(*(grid.to_point(open_) - start[:2]).T))] if len(open_) else None
    if here is None:
        return np.empty((0, 2))
    part = labels == labels[tuple(here)]
    if part[0].any() or part[-1].any() or part[:, 0].any() or part[:, -1].any():
        return np.empty((0, 2))
    return grid.to_point(np.argwhere(part))


def _is_known(grid: GridMap, points: FloatArray) -> FloatArray:
    """Return for each point (n, 2) on the map, in [m], 1 if its cell is known to be free or occupied,
    otherwise 0.
    """
    inside = grid.inside(points)
    found = np.zeros(len(points))
    rows, columns = grid.to_cell(points[inside]).T
    found[inside] = ~grid.unknown[rows, columns]
    return found


def _explored(survey: Survey, claim: Claim) -> list[str]:
    """Compare the drawn map with the fixed limits."""
    made = claim.primitive
    maps = list(made.evidence.maps.values())
    if not maps:
        return ["no map was drawn"]
    found = compare_with_world(survey.run, maps[-1], made.radius_m)
    median, high = (float(np.quantile(found.walls_mm, share)) for share in (0.5, 0.95))
    wrong = [
        *at_most("walls are {:.0f} mm off (median)", median, MAX_WALL_MEDIAN_MM, MAX_WALL_MEDIAN_MM),
        *at_most("walls are {:.0f} mm off (95 %)", high, MAX_WALL_95_MM, MAX_WALL_95_MM),
    ]
    if found.mapped_percent < MIN_MAPPED_PERCENT:
        words = f"{found.mapped_percent:.1f} % of the reachable floor is on the map"
        wrong.append(f"{words} (at least {MIN_MAPPED_PERCENT:g})")
    lacking = "the map lacks {:.1f} % of the walls beside its free floor"
    return wrong + at_most(lacking, found.missing_percent, MAX_MISSING_PERCENT, MAX_MISSING_PERCENT)


class MapSurvey(FiguresSurvey):
    """Evaluation of the maps that a run draws; it reports the errors of the last map."""

    name = "map"
    effects: ClassVar = {EXPLORE_NAME: _explored}

    @override
    def ended(self, number: int, primitive: ActionPrimitive, outcome: Outcome) -> list[str]:
        if primitive.label() == EXPLORE_NAME and isinstance(outcome, Success):
            drawn = list(primitive.evidence.maps.values())[-1]
            found = compare_with_world(self.run, drawn, float(getattr(primitive, "radius_m", np.inf)))
            self._figures["map_walls_mm_median"] = round(float(np.median(found.walls_mm)), 1)
            self._figures["map_walls_mm_95"] = round(float(np.quantile(found.walls_mm, 0.95)), 1)
            self._figures["map_walls_missing_percent"] = round(found.missing_percent, 2)
            if np.isfinite(found.mapped_percent):
                self._figures["map_floor_percent"] = round(found.mapped_percent, 2)
        return []
