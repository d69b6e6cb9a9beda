"""Tasks that begin without a pose: the network begins with LOCATE."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import cv2
import networkx as nx
import numpy as np

from handcart.backends.description.robot_file import RobotFile
from handcart.files.errors import Finding, InputError
from handcart.files.suggest import listed
from handcart.files.yaml.yaml_document import Document
from handcart.networks.graph.network import LOCATE_NAME, Action, ActionNetwork, Binding, Situation
from handcart.primitives.contract.action_primitive import ActionPrimitive
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.maps.grid_map import GridMap

LOCATE_COST_S = 30.0
UNLOCATED_NAME = "pose unknown"
"""Situation that is put before the start of a network without LOCATE."""
SCAN_LOCALIZERS = ("scan", "odometry")
ROOM_M = 0.1  # beside the footprint, where a simulated robot is set down
START_KEY = ("knowledge", "start")


class NotLocated(InputError):
    """Error: a run would begin without a pose in a situation from which no way leads to LOCATE."""


class Parts(NamedTuple):
    """Situations, actions and start of a network, before the network is built from them."""

    situations: list[Situation]
    actions: list[Action]
    start: str


def with_locate(parts: Parts, kind: type[ActionPrimitive]) -> Parts:
    """Return a network that begins with LOCATE, the primitive that finds the robot's pose on the map.

    A network that contains LOCATE already is returned unchanged.

    Args:
        parts: situations, actions and start of the network in the file.
        kind: class of LOCATE.
    """
    situations, actions, start = parts
    if has_locate(actions):
        return parts
    taken = {situation.name for situation in situations}
    names = [UNLOCATED_NAME, *(f"{UNLOCATED_NAME} {number}" for number in range(2, len(taken) + 3))]
    name = next(name for name in names if name not in taken)
    facts = next(situation.facts for situation in situations if situation.name == start)
    locate = Action(name, start, Binding(kind, {}, {}), LOCATE_COST_S)
    return Parts([Situation(name, facts), *situations], [*actions, locate], name)


def start_findings(document: Document, robot: RobotFile, has_map: bool) -> Iterator[Finding]:
    """Yield a finding if map, lidar, base or localizer are missing or unfit to find an unknown start pose."""
    missing = []
    if not has_map:
        missing.append("the key `map`")
    if robot.range_sensor is None:
        missing.append("a robot with a lidar")
    if robot.drive.kind == "ackermann":
        missing.append("a base that turns on the spot")
    elif robot.localizer not in SCAN_LOCALIZERS:
        missing.append(f"the localizer {' or '.join(SCAN_LOCALIZERS)}, not {robot.localizer}")
    if missing:
        wrong = f"an unknown start is found by scans on a map; needed: {', '.join(missing)}"
        yield document.finding(START_KEY, wrong)


def drawn_pose(grid: GridMap, radius: float, seed: int) -> Pose2:
    """Return a random pose map_T_base in the largest free part of a map, for the start of a simulated robot.

    It is the map's origin if the robot fits nowhere.

    Args:
        grid: the map.
        radius: radius of the footprint, in [m].
        seed: seed of the random pose.
    """
    rng = np.random.default_rng([seed, 4711])
    free = np.pad(~grid.blocked, 1).astype(np.uint8)
    clear = cv2.distanceTransform(free, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)[1:-1, 1:-1]
    labels = cv2.connectedComponents((clear * grid.resolution > radius + ROOM_M).astype(np.uint8))[1]
    sizes = np.bincount(labels.ravel())
    if len(sizes) < 2:
        return Pose2(0.0, 0.0, 0.0)
    cells = np.argwhere(labels == 1 + int(np.argmax(sizes[1:])))
    x, y = grid.to_point(cells[rng.integers(len(cells))][None])[0].tolist()
    return Pose2(x, y, float(rng.uniform(-np.pi, np.pi)))


def check_located(network: ActionNetwork, situation: str) -> None:
    """Raise `NotLocated` if no way leads to LOCATE from where a run begins without a pose."""
    ahead = {situation, *nx.descendants(network.graph, situation)}
    sources = {action.source: None for action in network.actions if _is_locate(action)}
    if not sources.keys() & ahead:
        wrong = f"the start pose is unknown, and no way leads from {situation!r} to LOCATE"
        raise NotLocated(f"{wrong}; allowed: {listed(sources)}, or a place as the task's start")


def has_locate(actions: Sequence[Action]) -> bool:
    """Return whether an action of a network is LOCATE."""
    return any(map(_is_locate, actions))


def _is_locate(action: Action) -> bool:
    return action.binding is not None and action.binding.label == LOCATE_NAME
