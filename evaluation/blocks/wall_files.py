"""A plan of a wall as a task with all its files."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

from handcart.files.maps.map_writing import write_grid
from handcart.files.whole_file import write_whole
from handcart.files.yaml.yaml_word import yaml_word
from handcart.primitives.blocks.building import Table
from handcart.primitives.knowledge.level_pose import LevelPose
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.maps.grid_map import GridMap, from_boxes

from .wall_planning import NamedStop, Trip, WallPlan

PEDESTAL_RATIO = 0.4  # of a table's side is its pedestal's
ROW_TONES = (154, 190, 215)  # of rows: a block cannot be distinguished from one of the same tone below it
STONE_GREY = 60


def write_wall(plan: WallPlan, chart: Path, robot: str, folder: Path, world: Path | None = None) -> None:
    """Write a task with its building plan, places, map, keepout zones, and world.

    Args:
        plan: how the wall is built.
        chart: file of the map; it is written anew into the folder.
        robot: name of the robot in the task.
        folder: created if it is missing.
        world: world file (default: tables, landmarks and blocks as drawn).

    Raises:
        OSError: a file cannot be written.
    """
    folder.mkdir(parents=True, exist_ok=True)
    if chart.resolve() != (folder / "map.yaml").resolve():
        write_grid(folder / "map.yaml", plan.grid, ".png")
    write_grid(folder / "keepout.yaml", plan.keepout, ".png")
    texts = {
        "task.yaml": TASK_TEMPLATE.format(
            count=len(plan.blocks), robot=yaml_word(robot), first=plan.trips[0].fetched_at.name
        ).replace("TRIPS", "\n".join(_trips(plan.trips))),
        "building.yaml": _building(plan),
        "places.yaml": _places(plan),
        "world.yaml": _world(plan) if world is None else world.read_text(encoding="utf-8"),
    }
    if world is None:
        write_grid(folder / "hall.yaml", _beside_tables(plan), ".png")
    for name, text in texts.items():
        write_whole(folder / name, text)


def _beside_tables(plan: WallPlan) -> GridMap:
    """Return the map without the tables, which are separate bodies in the simulated world."""
    grid = plan.grid
    outlines = [
        (table.x_m, table.y_m, table.floor.theta, *table.size_m) for table in plan.drawing.tables.values()
    ]
    size = grid.occupied.shape[1] * grid.resolution, grid.occupied.shape[0] * grid.resolution
    tables = from_boxes(outlines, grid.resolution, (grid.origin_x, grid.origin_y), size)
    return grid._replace(occupied=grid.occupied & ~tables.occupied)


def _building(plan: WallPlan) -> str:
    drawing, stops = plan.drawing, (*plan.fetching, *plan.laying)
    seen_from = {stop.landmark: stop.name for stop in reversed(stops)}
    lines = [
        "# What the robot is told of the wall; made by `handcart wall`. All on the map but `carried`.",
        "format: handcart-building/1",
        f"block_mm: [{', '.join(f'{side:g}' for side in drawing.block_mm)}]",
        "landmarks:",
    ]
    for name, mark in drawing.landmarks.items():
        place = seen_from.get(name, stops[0].name)
        lines.append(f"  {yaml_word(name)}: {{{_level(mark)}, side_mm: {mark.side_mm:g}, place: {place}}}")
    lines += [
        "tables:",
        *(f"  {yaml_word(name)}: {{{_table(table)}}}" for name, table in drawing.tables.items()),
    ]
    lines += ["supply:", *(f"  - {{{_level(pose)}}}" for pose in drawing.supply)]
    lines += ["carried:", *(f"  - {{{_level(item)}}}" for item in drawing.carried)]
    lines += ["goals:", *(f"  - {{{_level(block.place)}}}   # {block.words}" for block in plan.blocks)]
    return "\n".join(lines) + "\n"


def _places(plan: WallPlan) -> str:
    start = f"  start: {{{_pose(plan.drawing.start.pose)}}}"
    stops = [f"  {item.name}: {{{_pose(item.pose)}}}" for item in (*plan.fetching, *plan.laying)]
    head = "# Places of the robot's base; made by `handcart wall`.\nformat: handcart-places/1\nplaces:"
    return "\n".join([head, start, *stops]) + "\n"


def _world(plan: WallPlan) -> str:
    drawing = plan.drawing
    lines = [
        "# What stands there, as it is drawn; made by `handcart wall`. The robot doesn't see this file.",
        "format: handcart-world/1",
        "map: hall.yaml",
        f"start: {{{_pose(drawing.start.pose)}}}",
        "tables:",
    ]
    highest = [min(table.height_m for table in drawing.tables.values())]
    stones = {name: table for name, table in drawing.tables.items() if table.height_m > highest[0]}
    for name, table in drawing.tables.items():
        if name not in stones:
            foot = ", ".join(f"{PEDESTAL_RATIO * side:.3f}" for side in table.size_m)
            size = ", ".join(f"{side:g}" for side in (*table.size_m, table.height_m))
            lines.append(
                f"  - {{name: {yaml_word(name)}, {_pose(table.floor)}, size_m: [{size}], "
                f"slab_m: {table.thickness_m:g}, foot_m: [{foot}]}}"
            )
    lines += [
        "marks:",
        *(f"  - {{{_level(landmark)}}}" for landmark in drawing.landmarks.values()),
        "blocks:",
    ]
    for number, place in enumerate(drawing.supply, start=1):
        grey = _tone(plan, number)
        lines.append(f'  - {{name: "{number}", {_level(place)}, grey: {grey}}}')
    for name, stone in stones.items():
        size = ", ".join(f"{1e3 * side:g}" for side in (*stone.size_m, stone.thickness_m))
        foot = f"{_pose(stone.floor)}, height_m: {stone.height_m - stone.thickness_m:g}"
        lines.append(f"  - {{name: {yaml_word(name)}, {foot}, size_mm: [{size}], grey: {STONE_GREY}}}")
    return "\n".join(lines) + "\n"


def _tone(plan: WallPlan, number: int) -> int:
    if number > len(plan.blocks):
        return ROW_TONES[0]
    heights = sorted({block.place.height_m for block in plan.blocks})
    return ROW_TONES[heights.index(plan.blocks[number - 1].place.height_m) % len(ROW_TONES)]


def _trips(trips: Sequence[Trip]) -> list[str]:
    lines = []
    for number, trip in enumerate(trips):
        following = trips[min(number + 1, len(trips) - 1)].fetched_at
        count = len(trip.numbers)
        lines.append(
            f"    - {{{_stop('fetch', trip.fetched_at)}, {_stop('lay', trip.laid_at)}, "
            f"next: {following.name}, load: {count},"
        )
        for at, block in enumerate(trip.numbers):
            left = count - at
            last = str(left == 1).lower()
            text = f"{{number: {block}, loaded: {at}, left: {left}, after: {left - 1}, last: {last}}}"
            head, tail = "       blocks: [" if at == 0 else "                ", "]}" if left == 1 else ","
            lines.append(head + text + tail)
    return lines


def _stop(what: str, stop: NamedStop) -> str:
    return f"{what}: {stop.name}, {what}_by: {yaml_word(stop.landmark)}"


def _pose(pose: Pose2) -> str:
    return f"x_m: {pose.x:.4f}, y_m: {pose.y:.4f}, heading_deg: {math.degrees(pose.theta):.3f}"


def _level(place: LevelPose) -> str:
    turned = f", heading_deg: {place.heading_deg:.6g}" if place.heading_deg else ""
    return f"x_m: {place.x_m:.6g}, y_m: {place.y_m:.6g}, height_m: {place.height_m:.6g}{turned}"


def _table(table: Table) -> str:
    size = ", ".join(f"{side:g}" for side in table.size_m)
    return f"{_level(table)}, size_m: [{size}], thickness_m: {table.thickness_m:g}"


TASK_TEMPLATE = """\
# Builds a wall of {count} blocks; made by `handcart wall`. `trips` says what is fetched from which stop, and
# laid from which: of each block, how many lie on the robot before it is loaded, stacked, and after that.
format: handcart-task/1
title: Build a wall of {count} blocks
robot: {{parameter: robot}}
world: world.yaml
knowledge:
  map: map.yaml
  places: places.yaml
  keepout: keepout.yaml
  building: building.yaml
  start: start

parameters:
  robot: {robot}
  method: fix_again_imu
  trips:
TRIPS

start: at_rest
goal: built

situations:
  at_rest: {{base: where it sets out, load: 0}}
  at_supply: {{base: at the supply, load: 0}}
  to_load: {{base: at the supply, load: {{each: block.loaded}}}}
  taken: {{base: at the supply, load: {{each: block.loaded}}, hand: holds a block}}
  loaded: {{base: at the supply, load: {{each: trip.load}}}}
  at_wall: {{base: at the wall, load: {{each: trip.load}}}}
  to_stack: {{base: at the wall, load: {{each: block.left}}}}
  in_hand: {{base: at the wall, load: {{each: block.after}}, hand: holds a block}}
  stacked: {{base: at the wall, load: 0}}
  built: {{base: at the supply, load: 0}}

actions:
  - {{do: MOVE_TO, from: at_rest, to: at_supply, cost_s: 20, with: {{place: {first}}}}}
  - {{do: FIXATE, from: at_supply, to: to_load, cost_s: 6,
     with: {{landmark: {{each: trip.fetch_by}}, place: {{each: trip.fetch}}}}}}
  - {{do: PICK_UP_BLOCK, from: to_load, to: taken, cost_s: 6,
     with: {{number: {{each: block.number}}, at: supply}}}}
  - {{do: STACK, from: taken, to: loaded, cost_s: 6,
     with: {{number: {{each: block.number}}, onto: robot, stow: {{each: block.last}}}}}}
  - {{do: MOVE_TO, from: loaded, to: at_wall, cost_s: 20, with: {{place: {{each: trip.lay}}}}}}
  - {{do: FIXATE, from: at_wall, to: to_stack, cost_s: 6,
     with: {{landmark: {{each: trip.lay_by}}, place: {{each: trip.lay}}}}}}
  - {{do: PICK_UP_BLOCK, from: to_stack, to: in_hand, cost_s: 6,
     with: {{number: {{each: block.number}}, at: robot, look: true}}}}
  - {{do: STACK, from: in_hand, to: stacked, cost_s: 9,
     with: {{number: {{each: block.number}}, onto: goal, method: {{parameter: method}},
            stow: {{each: block.last}}}}}}
  - {{do: MOVE_TO, from: stacked, to: built, cost_s: 20, with: {{place: {{each: trip.next}}}}}}

repeat:
  - {{over: {{parameter: trips}}, as: trip, start: at_supply, goal: built}}
  - {{over: {{each: trip.blocks}}, as: block, start: to_load, goal: loaded}}
  - {{over: {{each: trip.blocks}}, as: block, start: to_stack, goal: stacked}}
"""
