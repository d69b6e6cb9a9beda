"""Create a task that tracks a seam from a robot and the seam, with a picture of the division."""

from __future__ import annotations

import math
from pathlib import Path
from typing import NamedTuple

import numpy as np

from handcart.backends.description.robot_file import RobotFile
from handcart.evaluation.viewing.drawing.picture_file import write_png
from handcart.files.errors import InputError
from handcart.files.whole_file import write_whole
from handcart.files.yaml.yaml_word import yaml_word
from handcart.primitives.driving.standing_room import StandingRoom
from handcart.primitives.outcomes.discrepancy import Discrepancy
from handcart.primitives.seam.seam_file import load_seam, untrackable
from handcart.primitives.seam.seam_placer import placer_of
from handcart.primitives.seam.work_piece import WorkBox, WorkPiece
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.manipulation.paths.tool_path import ToolPath
from handcart.robotics.manipulation.paths.untrackable import Untrackable
from handcart.robotics.manipulation.placement.placement_division import Division
from handcart.robotics.manipulation.placement.placements import Placements
from handcart.robotics.manipulation.placement.placer import Placer
from handcart.robotics.navigation.maps.grid_map import GridMap, from_boxes
from handcart.robotics.navigation.routes.ways import ROOM_AT_GOAL

from .placement_plots import DividedPath, draw_divisions

MAP_RESOLUTION_M = 0.05  # [m] of the map
FLOOR_MARGIN_M = 1.0  # [m] of floor beside what the arm reaches
START_DISTANCE_M = 0.8  # [m] from the first place that the robot sets out
SPARE_PLACES = 1  # places more than needed, in case that one is taken
OCCUPIED_MARGIN_M = 0.05  # [m] of floor on both sides of a seam that counts as occupied


class NoToolArm(InputError):
    """Error for a robot without a tool or an arm with which it could follow a seam."""

    def __init__(self, robot: RobotFile, reason: str) -> None:
        lacking = "arm" if robot.arm is None else "tool" if robot.tool is None else None
        self.key = ("arm", "joints") if lacking is None else ()
        """Key of the robot's file that causes the error."""
        super().__init__(f"{reason}; needed: a section `{lacking}`" if lacking else reason)


class PlacedSeam(NamedTuple):
    """Seam divided into parts, each with a pose of the base from which the arm can track it."""

    seam: ToolPath
    placements: Placements
    placer: Placer
    grid: GridMap
    work_piece: WorkPiece | None
    start: Pose2
    """Start of the robot."""

    @property
    def share(self) -> float:
        """Mean score of how well the arm reaches the seam, over the seam's length, from 0 to 1."""
        return self.placements.score / self.seam.length

    def words(self) -> list[str]:
        """Return a line of text for each pose of the base: the pose, and the part of the seam tracked from
        it.
        """
        lines = []
        for number, segment in enumerate(self.placements.segments, start=1):
            x, y, turn = self.placements.bases[segment.placement].tolist()
            first, last = self.seam.lengths[[segment.first, segment.last]].tolist()
            degrees = math.degrees(turn)
            lines.append(f"{number}. ({x:.2f}, {y:.2f}) m, {degrees:.0f} deg: {first:.2f} to {last:.2f} m")
        return lines


def place_seam(
    spec: RobotFile, file: Path, work_piece: WorkPiece | None = None, count: int | None = None
) -> PlacedSeam:
    """Divide a seam into parts, each with a pose of the base on an open floor from which it is tracked.

    Args:
        spec: robot file.
        file: file of the seam.
        work_piece: boxes around the seam; None: the floor under the seam counts as occupied.
        count: maximum number of poses of the base; None: as few as possible.

    Raises:
        FileError: the seam's file is invalid, or a point of it cannot be tracked: the first one, with the
            reason.
        NoToolArm: the robot has no tool, or no arm that can use it.
        UnknownPosture: the robot's file has no posture `home`.
    """
    seam = load_seam(file)
    try:
        placer = placer_of(spec)
    except Discrepancy as lacking:
        raise NoToolArm(spec, lacking.reason) from None
    grid = _floor(seam, placer, work_piece)
    boxes = tuple(box.box for box in work_piece.boxes) if work_piece else ()
    room = StandingRoom(spec, placer.arm, grid, np.empty((0, 2)), _corner(grid, spec), boxes)
    try:
        placements = placer.place(seam, room.blocked, count, room.free)
    except Untrackable as error:
        raise untrackable(str(file), error) from None
    start = _start(placements, seam, room)
    return PlacedSeam(seam, placements, placer, grid, work_piece, start)


def _floor(seam: ToolPath, placer: Placer, work_piece: WorkPiece | None) -> GridMap:
    bases = placer.candidates(seam)[:, :2]
    low, high = bases.min(axis=0) - FLOOR_MARGIN_M, bases.max(axis=0) + FLOOR_MARGIN_M
    if work_piece is not None:
        taken = [_outline(box) for box in work_piece.boxes]
    else:
        taken = [
            (x, y, 0.0, 2 * OCCUPIED_MARGIN_M, 2 * OCCUPIED_MARGIN_M) for x, y in seam.points[:, :2].tolist()
        ]
    low = np.floor(low / MAP_RESOLUTION_M) * MAP_RESOLUTION_M
    size = high - low
    return from_boxes(
        taken, MAP_RESOLUTION_M, (float(low[0]), float(low[1])), (float(size[0]), float(size[1]))
    )


def _outline(box: WorkBox) -> tuple[float, float, float, float, float]:
    return box.x_m, box.y_m, math.radians(box.heading_deg), box.size_m[0], box.size_m[1]


def _corner(grid: GridMap, spec: RobotFile) -> Pose2:
    """Return a pose in a corner of the floor, which is free by construction."""
    away = spec.footprint_radius_m + ROOM_AT_GOAL + 2 * MAP_RESOLUTION_M
    return Pose2(grid.origin_x + away, grid.origin_y + away, 0.0)


def _start(placements: Placements, seam: ToolPath, room: StandingRoom) -> Pose2:
    """Return a pose some distance back from the first place, or that place if the room is too small."""
    base = placements.bases[placements.segments[0].placement]
    back = base[:2] - seam.points[0, :2]
    spot = base.copy()
    spot[:2] += START_DISTANCE_M * back / max(1e-9, float(np.linalg.norm(back)))
    return Pose2(*(base if room.blocked(spot[None])[0] else spot).tolist())


def write_task(placed: PlacedSeam, file: Path, robot: str, folder: Path) -> None:
    """Write the files of a task that tracks a seam in parts, each from a base pose, and the picture
    `placements.svg`.

    Args:
        placed: the seam's parts, each with its base pose.
        file: file of the seam; it is copied.
        robot: name of the robot in the task.
        folder: created if it is missing.

    Raises:
        OSError: a file cannot be written.
    """
    folder.mkdir(parents=True, exist_ok=True)
    piece = placed.work_piece
    texts = {
        "seam.csv": file.read_text(encoding="utf-8"),
        "task.yaml": _task(placed, robot),
        "places.yaml": f"format: handcart-places/1\nplaces:\n  start: {_pose(placed.start)}\n",
        "world.yaml": _world(placed),
        "map.yaml": _map(placed.grid),
    }
    if piece is not None:
        boxes = "\n".join(f"  - {_box(box)}" for box in piece.boxes)
        texts["work_piece.yaml"] = f"format: handcart-work-piece/1\nboxes:\n{boxes}\n"
    for name, text in texts.items():
        write_whole(folder / name, text)
    write_png(folder / "map.png", np.where(placed.grid.occupied, 0, 254).astype(np.uint8)[::-1])
    draw_placements(placed, folder / "placements.svg")


def draw_placements(placed: PlacedSeam, target: Path) -> None:
    """Draw the seam and the poses of the base for its parts, as in figure 4 of Shin (2005).

    Raises:
        OSError: the file cannot be written.
    """
    division = Division(placed.placements.segments, placed.placements.score)
    panel = DividedPath(f"{len(division.segments)} placements", placed.placements.bases, division)
    draw_divisions(placed.seam, [panel], target, placed.placer.pitch_arm)


def _task(placed: PlacedSeam, robot: str) -> str:
    left = list(range(len(placed.placements.segments) + SPARE_PLACES, 0, -1))
    piece = "  work_piece: work_piece.yaml\n" if placed.work_piece else ""
    return TASK_TEMPLATE.format(length=placed.seam.length, robot=yaml_word(robot), left=left, piece=piece)


def _world(placed: PlacedSeam) -> str:
    boxes = placed.work_piece.boxes if placed.work_piece else ()
    lines = ["furniture:", *(f"  - {_box(box)}" for box in boxes)] if boxes else []
    return "\n".join(["format: handcart-world/1", f"start: {_pose(placed.start)}", *lines]) + "\n"


def _map(grid: GridMap) -> str:
    origin = f"[{grid.origin_x:.4f}, {grid.origin_y:.4f}, 0.0]"
    return (
        f"image: map.png\nresolution: {MAP_RESOLUTION_M}\norigin: {origin}\n"
        "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"
    )


def _pose(pose: Pose2) -> str:
    return f"{{x_m: {pose.x:.4f}, y_m: {pose.y:.4f}, heading_deg: {math.degrees(pose.theta):.3f}}}"


def _box(box: WorkBox) -> str:
    size = ", ".join(f"{side:g}" for side in box.size_m)
    stands = f"x_m: {box.x_m:g}, y_m: {box.y_m:g}, heading_deg: {box.heading_deg:g}, above_m: {box.above_m:g}"
    return f"{{name: {yaml_word(box.name)}, {stands}, size_m: [{size}]}}"


TASK_TEMPLATE = """\
# Tracks a seam of {length:.2f} m; made by `handcart place`.
format: handcart-task/1
title: Track a seam of {length:.2f} m
robot: {{parameter: robot}}
world: world.yaml
knowledge:
  map: map.yaml
  places: places.yaml
  seam: seam.csv
{piece}  start: start

parameters:
  robot: {robot}
  places_left: {left}    # among so many places at most; one is to spare

start: at_rest
goal: tracked

situations:
  at_rest: {{base: beside the work piece, arm: folded}}
  divided: {{base: beside the work piece, arm: folded}}
  at_place: {{base: beside the work piece, arm: folded}}
  tracked: {{base: beside the work piece, arm: folded}}

actions:
  - {{do: DIVIDE, from: at_rest, to: divided, cost_s: 2, with: {{placements: {{each: left}}}}}}
  - {{do: MOVE_TO, from: divided, to: at_place, on_fail: at_rest, cost_s: 20,
     with: {{place: {{model: seam_work.next.place}}, detour: false}}}}
  - {{do: TRACK, from: at_place, to: tracked, on_fail: at_rest, cost_s: 40}}

repeat: {{over: {{parameter: places_left}}, as: left, start: at_rest, goal: tracked}}
"""
