"""Floors of corridors around blocks, and drives through them with the errors of a robot's file."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import networkx as nx
import numpy as np

from handcart.backends.capabilities.base import Base, WheelTravel
from handcart.backends.capabilities.range_sensor import RangeSensor
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.kinematic.kinematic_backend import KinematicBackend
from handcart.backends.loading.robot_loading import load_robot
from handcart.backends.robot.localization.scan_reading import read_scan
from handcart.backends.simulation.world_files.world_model import world_model
from handcart.robotics.geometry.pose2 import Pose2, wrap
from handcart.robotics.navigation.mapping.scan_log import ScanLog
from handcart.robotics.numerics.arrays import FloatArray

ROBOT = "cart"
CORRIDOR_M = 2.4
WALL_M = 0.1
DOOR_M, NICHE_M = 1.0, 0.25
LOOK_AHEAD_M, SWITCH_M = 0.6, 0.2
MAX_TIME_FACTOR = 5.0
"""Maximum ratio of the drive's time to the time at top speed; a longer drive is stuck."""
SCAN_PERIODS = 4
"""Periods between two recorded scans."""
Box = tuple[float, float, float, float, float]
Boxes = list[Box]
Corner = tuple[int, int]


class Floor(NamedTuple):
    """A floor, and a way through it."""

    boxes: Boxes
    """Solids: x, y, yaw, length, width, in [m] and [rad]."""
    way: list[tuple[float, float]]
    """Waypoints in [m]."""

    @property
    def length(self) -> float:
        """Length of the way, in [m]."""
        return sum(math.dist(a, b) for a, b in zip(self.way, self.way[1:], strict=False))


class Drive(NamedTuple):
    """A recorded drive."""

    log: ScanLog
    truth: FloatArray
    """(n, 3) true pose at each scan: x, y in [m], heading in [rad]."""


def make_floor(seed: int, blocks: tuple[int, int], length: float) -> Floor:
    """Return a floor of blocks, so many along x and y, and a way of about `length` [m] through it.

    Walls have niches where doors are, and cabinets stand along them; no wall lies on a grid of cells.
    """
    rng = np.random.default_rng(seed)
    columns, rows = blocks
    widths, depths = rng.uniform(6.5, 9.5, columns), rng.uniform(5.0, 7.5, rows)
    lefts = CORRIDOR_M + np.concatenate([[0.0], np.cumsum(widths + CORRIDOR_M)])
    lows = CORRIDOR_M + np.concatenate([[0.0], np.cumsum(depths + CORRIDOR_M)])
    boxes = _outer_walls(rng, float(lefts[-1]), float(lows[-1]))
    for left, width in zip(lefts[:-1], widths, strict=True):
        for low, depth in zip(lows[:-1], depths, strict=True):
            boxes += _block(rng, float(left), float(low), float(width), float(depth))
    xs, ys = lefts - 0.5 * CORRIDOR_M, lows - 0.5 * CORRIDOR_M
    return Floor(boxes, _way(rng, xs.tolist(), ys.tolist(), length))


def _outer_walls(rng: np.random.Generator, right: float, top: float) -> Boxes:
    """Return walls around a floor, with niches."""
    boxes: Boxes = []
    for along, fixed, turned in (
        (right, 0.0, False),
        (right, top, False),
        (top, 0.0, True),
        (top, right, True),
    ):
        sign = -1.0 if fixed == 0.0 else 1.0
        at = -0.3
        while at < along:
            end = min(at + float(rng.uniform(2.0, 4.5)), along + 0.3)
            boxes.append(_strip(at, end, fixed + sign * WALL_M / 2, WALL_M, turned))
            door = min(end + DOOR_M, along + 0.3)
            boxes.append(_strip(end, door, fixed + sign * (NICHE_M + WALL_M / 2), WALL_M, turned))
            boxes.append(_strip(end - WALL_M, end, fixed + sign * NICHE_M / 2, NICHE_M + WALL_M, turned))
            boxes.append(_strip(door, door + WALL_M, fixed + sign * NICHE_M / 2, NICHE_M + WALL_M, turned))
            at = door
    return boxes


def _strip(begin: float, end: float, across: float, thick: float, turned: bool) -> Box:
    middle, long = 0.5 * (begin + end), max(end - begin, 0.01)
    return (across, middle, 0.0, thick, long) if turned else (middle, across, 0.0, long, thick)


def _block(rng: np.random.Generator, left: float, low: float, width: float, depth: float) -> Boxes:
    """Return a solid block with cabinets on its walls."""
    boxes: Boxes = [(left + width / 2, low + depth / 2, 0.0, width, depth)]
    for _ in range(int(rng.integers(4, 8))):
        thick, long = rng.uniform(0.2, 0.45), rng.uniform(0.4, 1.2)
        side, share = int(rng.integers(4)), rng.uniform(0.15, 0.85)
        if side < 2:
            y = low - thick / 2 if side == 0 else low + depth + thick / 2
            boxes.append((left + share * width, y, 0.0, long, thick))
        else:
            x = left - thick / 2 if side == 2 else left + width + thick / 2
            boxes.append((x, low + share * depth, 0.0, thick, long))
    return [tuple(float(value) for value in box) for box in boxes]  # type: ignore[misc]


def _way(
    rng: np.random.Generator, xs: list[float], ys: list[float], length: float
) -> list[tuple[float, float]]:
    """Return waypoints: a walk along the corridors that prefers those it has used least."""
    graph = nx.grid_2d_graph(len(xs), len(ys))
    used, at, last, total = dict[frozenset[Corner], int](), (0, 0), (-1, -1), 0.0
    way = [(xs[0], ys[0])]
    while total < length or at != (0, 0):
        near = [neighbor for neighbor in graph.neighbors(at) if neighbor != last] or [last]
        if total >= length:
            path = nx.shortest_path(graph, at, (0, 0))
            near = [path[1]]
        counts = [used.get(frozenset((at, item)), 0) for item in near]
        best = [item for item, count in zip(near, counts, strict=True) if count == min(counts)]
        chosen = best[int(rng.integers(len(best)))]
        used[frozenset((at, chosen))] = used.get(frozenset((at, chosen)), 0) + 1
        last, at = at, chosen
        way.append((xs[at[0]], ys[at[1]]))
        total += math.dist(way[-2], way[-1])
    return way


def drive(floor: Floor, seed: int, robot: str = ROBOT) -> Drive:
    """Drive along a floor's way, as a person who sees the robot would, and record scans and odometry."""
    spec = load_robot(robot)
    assert spec.range_sensor is not None and spec.drive.tread_m is not None
    (x, y), (ahead_x, ahead_y) = floor.way[:2]
    heading = math.degrees(math.atan2(ahead_y - y, ahead_x - x))
    world = {
        "format": "handcart-world/1",
        "start": {"x_m": x, "y_m": y, "heading_deg": heading},
        "furniture": [
            {
                "name": f"box {n}",
                "x_m": b[0],
                "y_m": b[1],
                "heading_deg": math.degrees(b[2]),
                "size_m": [b[3], b[4], 2.0],
            }
            for n, b in enumerate(floor.boxes)
        ],
    }
    with KinematicBackend(spec, world_model().model_validate(world), seed) as backend:
        return _record(backend, spec, floor.way)


def _record(backend: KinematicBackend, spec: RobotFile, way: list[tuple[float, float]]) -> Drive:
    base, lidar = backend.get(Base), backend.get(RangeSensor)  # type: ignore[type-abstract]
    assert base is not None and lidar is not None and spec.range_sensor is not None
    odometry, last = Pose2(0.0, 0.0, 0.0), base.wheel_travel()
    rows = list[tuple[float, Pose2, Pose2, FloatArray]]()
    first = None
    for number, command in enumerate(_commands(backend, spec, way)):
        if number % SCAN_PERIODS == 0:
            scan = read_scan(lidar.scan(), spec.range_sensor, spec.footprint_shape)
            first = first or scan
            truth = _true_pose(backend)
            ranges = np.where(scan.blind(), math.nan, scan.ranges)
            rows.append((number * backend.period, odometry, truth, ranges))
        base.drive(*command)
        backend.step()
        travel = base.wheel_travel()
        odometry, last = _moved(odometry, last, travel, spec), travel
    assert first is not None
    times, odometries, truths, ranges = (np.array(item) for item in zip(*rows, strict=True))
    log = ScanLog(times, odometries, first.angles, ranges, first.base_T_sensor, spec.range_sensor.reach_m)
    return Drive(log, truths)


def _true_pose(backend: KinematicBackend) -> Pose2:
    pose = backend.scene.world_T_base
    return Pose2(float(pose[0, 3]), float(pose[1, 3]), math.atan2(pose[1, 0], pose[0, 0]))


def _moved(pose: Pose2, last: WheelTravel, travel: WheelTravel, spec: RobotFile) -> Pose2:
    """Return the odometry's pose after the wheels have rolled on, on an arc."""
    left, right = travel.left - last.left, travel.right - last.right
    turn, way = (right - left) / spec.drive.tread_m, 0.5 * (left + right)
    return pose.compose(Pose2(way * math.cos(turn / 2), way * math.sin(turn / 2), turn))


def _commands(
    backend: KinematicBackend, spec: RobotFile, way: list[tuple[float, float]]
) -> Iterator[tuple[float, float]]:
    """Yield speed and turn rate towards a point ahead on the way, until its end."""
    top, top_turn = 0.9 * spec.drive.top_speed_m_s, 0.9 * math.radians(spec.drive.top_turn_deg_s)
    leg, limit = 1, int(MAX_TIME_FACTOR * Floor([], way).length / top / spec.period_s)
    for _ in range(limit):
        pose = _true_pose(backend)
        begin, end = np.array(way[leg - 1]), np.array(way[leg])
        long = float(np.linalg.norm(end - begin))
        along = float((np.array(pose[:2]) - begin) @ (end - begin)) / long
        if along > long - (SWITCH_M if leg < len(way) - 1 else 0.05):
            leg += 1
            if leg == len(way):
                return
            continue
        aim = begin + min(along + LOOK_AHEAD_M, long + LOOK_AHEAD_M) / long * (end - begin)
        off = wrap(math.atan2(aim[1] - pose.y, aim[0] - pose.x) - pose.theta)
        yield top * max(0.0, 1.0 - 1.5 * abs(off)), float(np.clip(2.0 * off, -top_turn, top_turn))
    raise RuntimeError(f"the drive is stuck at {_true_pose(backend)}")
