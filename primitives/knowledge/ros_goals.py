"""Goals as users of nav2 keep them, read as the places of a map."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from handcart.files.errors import FileError, Finding
from handcart.files.findings import Findings
from handcart.files.yaml.yaml_document import Document
from handcart.files.yaml.yaml_node import Node

GOAL_LIST_KEYS = ("waypoints", "goals", "poses")
"""Keys that hold goals: rviz's panel, NavigateThroughPoses, nav_msgs/Path and PoseArray."""
MAP_FRAMES = ("map", "/map", "")
MAX_TILT_RAD = math.radians(5.0)
QUATERNION_TOLERANCE = 0.02  # by which the length of a quaternion may differ from 1: ROS prints few digits


def goals_as_places(document: Document) -> Document:
    """Return a file of goals as a file of places; every value keeps its line and column.

    A goal is a PoseStamped or a Pose (`position` and `orientation` with x, y, z, w), a pose of rviz's
    panel (`pose: [x, y, z]`, `orientation: [w, x, y, z]`), `x`, `y` and `yaw` (or `theta`) in rad, or a
    list `[x, y, theta]`. Its name is its key, its `name`, or goal_1, goal_2 ...

    Raises:
        FileError: lists every goal that is unreadable, tilted, or in another frame than the map's.
    """
    root, findings = document.root, Findings()
    listed = root if isinstance(root.content, list) else _listed(root)
    places: dict[str, Node] = {}
    if listed is not root:
        findings.add(*_frame(root))
    for name, goal in _named(listed):
        if name in places:
            findings.add(_at(goal, f"the goal {name!r} is there twice; allowed: each name once"))
            continue
        try:
            places[name] = _place(goal)
        except FileError as error:
            findings.take(error)
    if not places and not findings:
        findings.add(_at(listed, "no goals; allowed: a list of poses"))
    findings.raise_all()
    format_node = replace(root, content="handcart-places/1")
    whole = replace(root, content={"format": format_node, "places": replace(listed, content=places)})
    return replace(document, root=whole)


def _listed(root: Node) -> Node:
    """Return the node of the list of goals, which ROS messages may nest under several of its keys."""
    for key in GOAL_LIST_KEYS:
        if (found := root.child(key)) is not None:
            return _listed(found)
    return root


def _named(listed: Node) -> Iterator[tuple[str, Node]]:
    if isinstance(listed.content, dict):
        yield from listed.content.items()
    elif isinstance(listed.content, list):
        for number, goal in enumerate(listed.content, start=1):
            named = goal.child("name")
            name = named.content if named is not None else f"goal_{number}"
            yield str(name), goal
    else:
        raise FileError([_at(listed, "no list of goals; allowed: poses in a list, or by their names")])


def _place(entry: Node) -> Node:
    """Return the keys x_m, y_m and heading_deg of a goal, each with its line and column."""
    if wrong := [*_frame(entry)]:
        raise FileError(wrong)
    if isinstance(entry.content, list) and len(entry.content) != 3:
        raise FileError([_at(entry, f"the goal has {len(entry.content)} numbers; allowed: [x, y, theta]")])
    goal, pose = entry, entry.child("pose")
    if pose is not None and isinstance(pose.content, dict):
        goal = pose.child("pose") or pose  # a PoseWithCovariance holds another one
    position = goal.child("position") or pose or goal
    x, y = _number(position, "x", 0), _number(position, "y", 1)
    turn = goal.child("orientation")
    if turn is None:
        key = "theta" if goal.child("theta") else "yaw"
        yaw, angle = _number(goal, key, 2), goal.child(key) or goal
    else:
        yaw, angle = _yaw(turn), turn
    heading = replace(angle, content=math.degrees(yaw))
    place: dict[str, Node] = {
        "x_m": _where(position, "x", 0, x),
        "y_m": _where(position, "y", 1, y),
        "heading_deg": heading,
    }
    return replace(entry, content=place)


def _yaw(turn: Node) -> float:
    """Return the heading in [rad] of a quaternion; as a list it begins with w, as rviz saves it."""
    w, x, y, z = (_number(turn, key, index) for index, key in enumerate("wxyz"))
    length = math.sqrt(w * w + x * x + y * y + z * z)
    if abs(length - 1.0) > QUATERNION_TOLERANCE:
        wrong = f"the orientation is a quaternion of length {length:.3g}; allowed: 1"
        raise FileError([_at(turn, wrong)])
    tilt = math.acos(max(-1.0, min(1.0, 1.0 - 2.0 * (x * x + y * y) / length**2)))
    if tilt > MAX_TILT_RAD:
        raise FileError(
            [_at(turn, f"the goal is tilted by {math.degrees(tilt):.0f} deg; allowed: a robot upright")]
        )
    return math.atan2(2.0 * (w * z + x * y), length**2 - 2.0 * (y * y + z * z))


def _number(node: Node, key: str, index: int) -> float:
    """Return a number of a mapping, or of a list."""
    found = node.child(key) or node.child(index)
    value: Any = found.content if found is not None else None
    if found is None or isinstance(value, bool) or not isinstance(value, int | float):
        raise FileError(
            [_at(found or node, f"the goal has no number {key!r} here; needed: {key} of its pose")]
        )
    return float(value)


def _where(node: Node, key: str, index: int, value: float) -> Node:
    return replace(node.child(key) or node.child(index) or node, content=value)


def _frame(node: Node) -> Iterator[Finding]:
    header = node.child("header")
    frame = (header.child("frame_id") if header is not None else None) or node.child("frame_id")
    if frame is not None and frame.content not in MAP_FRAMES:
        yield _at(frame, f"the goal is in the frame {frame.content!r}; allowed: map")


def _at(node: Node, message: str) -> Finding:
    return Finding(node.file, node.line, node.column, message)
