"""Files of an activity: its world, what the robot knows, and its task."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from handcart.backends.simulation.world_files.load_world import load_world
from handcart.backends.simulation.world_files.world_map import map_of_world
from handcart.files.maps.map_writing import write_grid
from handcart.files.whole_file import write_whole
from handcart.files.yaml.yaml_word import yaml_word
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.maps.grid_map import from_boxes

from .activity_task import task_text
from .definition import Definition
from .furniture import FurnitureLevel, Piece
from .placement import DEPTH_M
from .room import SIDE_TABLE, SIDE_TABLE_POSE, SIDE_TABLE_SIZE_M, Room
from .slots import ThingSlot
from .thing_table import CarriedEntry

OFF_MM, OFF_DEG = 10.0, 5.0
"""Standard deviations of position and heading with which a person sets things in rows, in [mm] and [deg]."""
BELIEF_DEG = 10.0
"""Standard deviation that the robot assumes for a thing's heading, in [deg]."""
LIDAR_HEIGHT_M = 0.2
RESOLUTION_M = 0.02
LEGS_M = 0.005  # by which a surface is thinner than high if a lidar can't measure its sides
MIN_TOP_MM = 22.0
"""Narrowest top on which a tag is put; on a narrower thing the tags are on two upright sides."""
QUIET = 1.45
"""Ratio of a tag's side with its white margin to the side of its black square."""
MAX_TAG_MM = 40.0


def write_activity(definition: Definition, room: Room, folder: Path, robot: str) -> list[Path]:
    """Write the files of an activity into a folder: world, map, places, objects, definition and task.

    Return the paths of the files.

    Raises:
        OSError: the folder cannot be written.
    """
    folder.mkdir(parents=True, exist_ok=True)
    head = f"# {definition.name}, definition {definition.instance} of BEHAVIOR-1K"
    texts = {
        "world.yaml": f"{head}: its true state at first. The robot doesn't see this file.\n{_world(room)}",
        "places.yaml": f"format: handcart-places/1\nplaces:\n  home: {_pose(room.home)}\n",
        "objects.yaml": f"{head}: what the robot knows.\n{_objects(room)}",
        "activity.yaml": f"{head}: names of its terms, for its judge.\n{_activity(definition, room)}",
        "task.yaml": task_text(definition, room, robot),
    }
    for name, text in texts.items():
        write_whole(folder / name, text)
    pictures = ["map.yaml", "map.png"]
    _write_map(folder)
    if floor_levels(room):
        _write_keepout(folder, room)
        pictures += ["keepout.yaml", "keepout.png"]
    return [folder / name for name in (*texts, *pictures)]


def floor_levels(room: Room) -> list[tuple[Piece, FurnitureLevel]]:
    """Return the areas of the floor that carry things, each with the piece of furniture it belongs to."""
    return [(piece, level) for piece in room.pieces for level in piece.levels() if level.height <= 0.0]


def _world(room: Room) -> str:
    corners = [(0.0, 0.0), (room.width, 0.0), (room.width, DEPTH_M), (0.0, DEPTH_M)]
    lines = ["format: handcart-world/1", f"start: {_pose(room.home)}", "walls:"]
    for begin, end in zip(corners, [*corners[1:], corners[0]], strict=True):
        lines.append(f"  - {_flow({'from_m': list(begin), 'to_m': list(end)})}")
    bodies = [item for piece in room.pieces for item in piece.parts()]
    lines += ["furniture:"] if bodies else []
    for piece in room.pieces:
        for part in piece.parts():
            pose = piece.in_room(part.x, part.y)
            above = {"above_m": part.above} if part.above else {}
            lines.append(f"  - {_flow({'name': part.name, **_at(pose), 'size_m': list(part.size), **above})}")
    if room.has_side_table:
        lines.append(
            f"  - {_flow({'name': SIDE_TABLE, **_at(SIDE_TABLE_POSE), 'size_m': list(SIDE_TABLE_SIZE_M)})}"
        )
    floors = floor_levels(room)
    lines += ["floor_areas:"] if floors else []
    for piece, level in floors:
        pose = piece.in_room(level.x, level.y)
        lines.append(f"  - {_flow({'name': level.name, **_at(pose), 'size_m': list(level.size)})}")
    lines.append("objects:")
    lines += [f"  - {_flow(_true_object(room, term, slot))}" for term, slot in room.at_first.items()]
    return "\n".join(lines) + "\n"


def _true_object(room: Room, term: str, slot: ThingSlot) -> dict[str, Any]:
    entry = room.sizes[term]
    shape = {"shape": entry.shape} if entry.shape != "box" else {}
    return {
        "name": room.names[term],
        **shape,
        **_at(slot.pose),
        "height_m": slot.level.height,
        "size_mm": list(entry.size_mm),
        "mass_kg": entry.mass_kg,
        "sigma_mm": OFF_MM,
        "sigma_deg": OFF_DEG,
        "tags": _tags(room, term),
    }


def _tags(room: Room, term: str) -> list[dict[str, Any]]:
    """Return the tags of a thing: on its top, or on two sides where the top is too narrow."""
    entry = room.sizes[term]
    first = 2 * list(room.at_first).index(term)
    x, y, z = entry.size_mm
    top = x * math.sqrt(0.5) if entry.shape == "cylinder" else min(x, y)
    if top >= MIN_TOP_MM or entry.shape == "cylinder":
        return [{"id": first, "side_mm": _tag_side(top)}]
    side = _tag_side(min(y, z))
    return [{"id": first + number, "side_mm": side, "face": face} for number, face in enumerate(("-x", "+x"))]


def _tag_side(room_mm: float) -> float:
    return round(min(MAX_TAG_MM, room_mm / QUIET), 1)


def _objects(room: Room) -> str:
    lines = ["format: handcart-objects/1", "kinds:"]
    kinds = {_kind(room, term): entry for term, entry in room.sizes.items()}
    lines += [f"  {name}: {_flow(_kind_keys(entry))}" for name, entry in kinds.items()]
    lines.append("surfaces:")
    for piece in room.pieces:
        levels = {level.name for level in piece.levels()}
        at = [item.level for item in (*room.at_first.values(), *room.at_end.values())]
        used = {item.relation for item in at if item.name in levels}
        for level in piece.levels():
            spots = {
                f"for_{room.names[term]}": {**_at(slot.pose)}
                for term, slot in room.at_end.items()
                if slot.level == level
            }
            if level.relation not in used:
                continue
            keys: dict[str, Any] = {**_at(piece.in_room(level.x, level.y)), "height_m": level.height}
            keys["size_m"] = [round(item, 4) for item in level.size]
            if level.thickness > 0.0 and (level.thickness < level.height or _is_part(piece, level)):
                keys["thickness_m"] = round(min(level.thickness, level.height - LEGS_M), 4)
            if level.clearance is not None:
                keys |= {"clearance_m": level.clearance, "ceiling_m": round(level.ceiling, 4)}
            if level.walls:
                keys["walls"] = list(level.walls)
            if level.wall_height is not None:
                keys["wall_m"] = round(level.wall_height, 4)
            keys["kinds"] = _kinds_on(room, level)
            lines.append(f"  {level.name}: {_flow(keys | ({'spots': spots} if spots else {}))}")
    if room.has_side_table:
        lines.append(f"  {SIDE_TABLE}: {_flow(_side_table(room))}")
    lines.append("objects:")
    for term, slot in room.at_first.items():
        keys = {"kind": _kind(room, term), "on": slot.level.name, **_at(slot.pose), "sigma_deg": BELIEF_DEG}
        lines.append(f"  {room.names[term]}: {_flow({**keys, 'tags': _tags(room, term)})}")
    return "\n".join(lines) + "\n"


def _side_table(room: Room) -> dict[str, Any]:
    *size, height = SIDE_TABLE_SIZE_M
    kinds = [_kind(room, term) for term in room.at_end if room.is_regripped(term)]
    return {
        **_at(SIDE_TABLE_POSE),
        "height_m": height,
        "size_m": size,
        "kinds": list(dict.fromkeys(kinds)),
    }


def _is_part(piece: Piece, level: FurnitureLevel) -> bool:
    """Return whether a level is a part of a top: a lidar doesn't see where it ends, so it isn't measured."""
    return level.size[0] < piece.entry.size_m[0]


def _kinds_on(room: Room, level: FurnitureLevel) -> list[str]:
    """Return the kinds of things that are on a level at first or at the end."""
    terms = [term for slots in (room.at_first, room.at_end) for term in slots if slots[term].level == level]
    return list(dict.fromkeys(_kind(room, item) for item in terms))


def _kind(room: Room, term: str) -> str:
    return room.names[term].rpartition("_")[0]


def _kind_keys(entry: CarriedEntry) -> dict[str, Any]:
    shape = {"shape": entry.shape} if entry.shape != "box" else {}
    return {**shape, "size_mm": list(entry.size_mm), "mass_kg": entry.mass_kg}


def _activity(definition: Definition, room: Room) -> str:
    lines = [
        "format: handcart-activity/1",
        f"activity: {yaml_word(definition.name)}",
        f"definition: {definition.instance}",
    ]
    lines.append("furniture:" if any(list(piece_.parts()) for piece_ in room.pieces) else "furniture: {}")
    bodies = {piece_.term: [part.name for part in piece_.parts()] for piece_ in room.pieces}
    lines += [f"  {term}: {_flow(parts)}" for term, parts in bodies.items() if parts]
    lines.append("objects:")
    lines += [f"  {term}: {room.names[term]}" for term in room.at_first]
    if room.floors:
        lines.append("floors:   # least x and y, greatest x and y")
        lines += [f"  {term}: {_flow(list(extent))}" for term, extent in room.floors.items()]
    if room.beside:
        lines.append("beside:   # moved objects, and the terms that they have to be next to")
        lines += [f"  {room.names[term]}: {other}" for term, other in room.beside.items()]
    lines.append("goal:     # surfaces that each moved object may be on")
    pieces = {level.name: piece for piece in room.pieces for level in piece.levels()}
    for term, slot in room.at_end.items():
        levels = pieces[slot.level.name].levels()
        allowed = [
            furniture_level.name
            for furniture_level in levels
            if furniture_level.relation == slot.level.relation
        ]
        lines.append(f"  {room.names[term]}: {_flow(allowed)}")
    return "\n".join(lines) + "\n"


def _write_map(folder: Path) -> None:
    grid = map_of_world(load_world(folder / "world.yaml"), LIDAR_HEIGHT_M, RESOLUTION_M)
    write_grid(folder / "map.yaml", grid, ".png")


def _write_keepout(folder: Path, room: Room) -> None:
    """Write the areas of the floor that carry things as zones that the base keeps out of."""
    outlines = []
    for piece, level in floor_levels(room):
        pose = piece.in_room(level.x, level.y)
        outlines.append((pose.x, pose.y, pose.theta, *level.size))
    size = (room.width, DEPTH_M)
    write_grid(folder / "keepout.yaml", from_boxes(outlines, RESOLUTION_M, (0.0, 0.0), size), ".png")


def _at(pose: Pose2) -> dict[str, float]:
    """Return a pose as a mapping with the keys `x_m`, `y_m` and `heading_deg`."""
    heading = round(math.degrees(pose.theta), 3) + 0.0
    return {"x_m": round(pose.x, 4) + 0.0, "y_m": round(pose.y, 4) + 0.0, "heading_deg": heading}


def _pose(pose: Pose2) -> str:
    return _flow(_at(pose))


def _flow(value: Any) -> str:
    """Return a value in YAML's flow style."""
    if isinstance(value, Mapping):
        return "{" + ", ".join(_pairs(value)) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(_flow(item) for item in value) + "]"
    if isinstance(value, float):
        return f"{value:g}"
    text = str(value)
    return f'"{text}"' if text[:1] in "+-" and isinstance(value, str) else text


def _pairs(mapping: Mapping[str, Any]) -> Iterator[str]:
    for key, item in mapping.items():
        yield f"{key}: {_flow(item)}"
