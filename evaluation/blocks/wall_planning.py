"""Plan stops of the base and the order of the blocks from a drawing of a wall and a robot."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby
from typing import NamedTuple

import numpy as np

from handcart.backends.description.robot_file import RobotFile
from handcart.files.errors import FileError
from handcart.files.models.loading import Loaded
from handcart.primitives.blocks.drawing import Drawing, DrawnBlock
from handcart.primitives.blocks.laying_order import laying_orders, wall_findings
from handcart.primitives.driving.standing_room import StandingRoom
from handcart.primitives.knowledge.level_pose import LevelPose
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.kinematics.shapes import Box
from handcart.robotics.manipulation.paths.untrackable import Untrackable
from handcart.robotics.manipulation.placement.stops import BaseStop
from handcart.robotics.navigation.maps.grid_map import GridMap, from_boxes
from handcart.robotics.navigation.maps.keepout import with_keepout
from handcart.robotics.navigation.routes.ways import Ways
from handcart.robotics.numerics.arrays import FloatArray

from .stop_reach import StopReach
from .swept_zones import swept_zones

MIN_STOP_GAIN = 0.3  # scores of blocks that one more stop has to gain


class NamedStop(NamedTuple):
    """Place at which the base stops to fetch or lay blocks, with scores of how well the arm reaches the
    blocks.
    """

    name: str
    pose: Pose2
    """map_T_base."""
    landmark: str
    """Landmark that the robot looks at from the stop."""
    numbers: range
    """Numbers of the blocks, from 1 in the order of laying."""
    score: float
    """Mean score of the stop's blocks, 0 to 1."""
    least: int
    """Number of the block with the lowest score."""
    clearance: float
    """Distance from the base's middle to the nearest obstacle, in [m]."""

    def words(self) -> str:
        """Return a line of text with the stop's name, pose, blocks, scores and clearance."""
        x, y, turn = self.pose
        blocks = f"blocks {self.numbers[0]} to {self.numbers[-1]}"
        stands = f"({x:.2f}, {y:.2f}) m, {np.degrees(turn):.0f} deg"
        worth = f"score {self.score:.2f}, least at block {self.least}"
        return f"{self.name} {stands}: {blocks}, {worth}; {self.clearance:.2f} m to what stands there"


class Trip(NamedTuple):
    """Blocks that the robot fetches at one stop, carries together, and lays at another stop."""

    fetched_at: NamedStop
    laid_at: NamedStop
    numbers: range
    """Numbers of the blocks, from 1."""


class WallPlan(NamedTuple):
    """Plan by which a robot builds a wall, with the blocks' order, the base's stops and keepout zones."""

    drawing: Drawing
    blocks: tuple[DrawnBlock, ...]
    """Blocks in the order in which they are laid: block 1 is the first."""
    fetching: tuple[NamedStop, ...]
    laying: tuple[NamedStop, ...]
    grid: GridMap
    """The map."""
    keepout: GridMap
    """Zones for the base to keep out of."""

    @property
    def trips(self) -> list[Trip]:
        """Trips of the robot, each from a stop where it fetches blocks to a stop where it lays them.

        A trip has at most as many blocks as the robot can carry.
        """
        found = []
        numbers = range(1, len(self.blocks) + 1)
        for (fetched, laid), group in groupby(
            numbers, lambda n: (_of(self.fetching, n), _of(self.laying, n))
        ):
            several, most = list(group), len(self.drawing.carried)
            for at in range(0, len(several), most):
                part = several[at : at + most]
                found.append(Trip(fetched, laid, range(part[0], part[-1] + 1)))
        return found


def plan_wall(loaded: Loaded[Drawing], spec: RobotFile, grid: GridMap) -> WallPlan:
    """Plan the base's stops from which a robot takes the blocks of a drawing and lays them.

    Args:
        loaded: the drawing.
        spec: the robot's file.
        grid: the map.

    Raises:
        FileError: blocks of the wall cannot be laid; the message says which, and why.
        Discrepancy: the robot lacks arm, gripper or camera.
    """
    found = list(wall_findings(loaded))
    if found:
        raise FileError(found)
    drawing = loaded.value
    start = drawing.start.pose
    reach = StopReach(spec, drawing.block)
    keepout = _keepout(drawing, spec, reach, grid)
    barred = with_keepout(grid, keepout)
    room = StandingRoom(spec, reach.placer.arm, barred, np.empty((0, 2)), start)
    planning = _Planning(drawing, reach, room, Ways(barred, spec.footprint_shape, start))
    count = len(drawing.blocks)
    try:
        fetching = planning.stops(drawing.supply[:count], "supply", held=False)
    except Untrackable as error:
        key = ("supply", error.index)
        raise loaded.refuse(key, _refusal(f"block {error.index + 1} of the supply", error)) from None
    refusals, best = list[FileError](), None
    for order in laying_orders(drawing):
        try:
            laying = planning.stops([block.place for block in order], "wall", held=True)
        except Untrackable as error:
            block = order[error.index]
            refusals.append(loaded.refuse(block.key, _refusal(block.words, error)))
            continue
        plan = WallPlan(drawing, tuple(order), fetching, laying, grid, keepout)
        if best is None or _worth(plan) > _worth(best):
            best = plan
        if len(laying) == 1:
            break  # no order needs fewer
    if best is None:
        raise refusals[0]
    return best


class _Planning(NamedTuple):
    """Inputs common to both ends of the route."""

    drawing: Drawing
    reach: StopReach
    room: StandingRoom
    ways: Ways

    def stops(self, places: Sequence[LevelPose], name: str, held: bool) -> tuple[NamedStop, ...]:
        """Return named stops for blocks at places, in their order; raises `Untrackable`."""
        around = self._around(places, held)

        def touches(base: FloatArray, number: int) -> str:
            return self.reach.touches(base, places[number], around[number], held)

        placer = self.reach.stops(list(self.drawing.landmarks.values()))
        goals = [self.reach.goal(place) for place in places]
        stops = placer.place(goals, self.room.blocked, touches, MIN_STOP_GAIN)
        return tuple(self._named(f"{name}_{n}", stop, places) for n, stop in enumerate(stops, start=1))

    def _around(self, places: Sequence[LevelPose], held: bool) -> list[list[Box]]:
        """Return the bodies around each block when the hand comes: tables, and blocks already laid or still
        waiting.
        """
        bodies = [self.reach.body(place, f"block {n}") for n, place in enumerate(places, start=1)]
        tables = [table.box for table in self.drawing.tables.values()]
        return [[*tables, *(bodies[:n] if held else bodies[n + 1 :])] for n in range(len(places))]

    def _named(self, name: str, stop: BaseStop, places: Sequence[LevelPose]) -> NamedStop:
        marks = list(self.drawing.landmarks)
        middle = np.mean([places[n].floor[:2] for n in range(stop.first, stop.last + 1)], axis=0)

        def off(number: int) -> float:
            return float(np.linalg.norm(self.drawing.landmarks[marks[number]].floor[:2] - middle))

        pose = Pose2(*stop.base.tolist())
        numbers = range(stop.first + 1, stop.last + 2)
        least = numbers[int(np.argmin(stop.scores))]
        mark = marks[min(stop.sights, key=off)]
        return NamedStop(
            name, pose, mark, numbers, float(stop.scores.mean()), least, self.ways.to(pose).clearance
        )


def _keepout(drawing: Drawing, spec: RobotFile, reach: StopReach, grid: GridMap) -> GridMap:
    blocks = [*drawing.supply, *(block.place for block in drawing.blocks)]
    things = [table.box for table in drawing.tables.values()]
    things += [reach.body(place, "block") for place in blocks]
    height, width = grid.occupied.shape
    size = width * grid.resolution, height * grid.resolution
    zones = swept_zones(spec, things)
    return from_boxes(zones, grid.resolution, (grid.origin_x, grid.origin_y), size)


def _of(stops: Sequence[NamedStop], number: int) -> NamedStop:
    return next(stop for stop in stops if number in stop.numbers)


def _worth(plan: WallPlan) -> float:
    scores = sum(stop.score * len(stop.numbers) for stop in plan.laying)
    return scores - MIN_STOP_GAIN * len(plan.trips)


def _refusal(words: str, error: Untrackable) -> str:
    return f"{words} {error.why}; needed: another place for it, its table or its landmark"
