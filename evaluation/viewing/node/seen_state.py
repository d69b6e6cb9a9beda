"""State of a run as its node publishes it."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from handcart.backends.robot.robot import Robot
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.tracking.people import People
from handcart.robotics.numerics.arrays import FloatArray

NO_POINTS = np.empty((0, 2))


@dataclass(frozen=True)
class SeenState:
    """Estimated pose, paths and contacts of a robot at one time of a run, in the frame of the robot's map."""

    pose: Pose2
    """map_T_base."""
    covariance: FloatArray
    """(3, 3) covariance of the pose, of x, y in [m] and heading in [rad]."""
    planned: FloatArray = field(default_factory=NO_POINTS.copy)
    """(n, 2) path that the action plans to drive, in [m]."""
    driven: FloatArray = field(default_factory=NO_POINTS.copy)
    """(n, 2) path that the robot believes to have driven in this action, in [m]."""
    felt: FloatArray = field(default_factory=NO_POINTS.copy)
    """(n, 2) points where the base touched something, in [m]."""
    people: FloatArray = field(default_factory=lambda: np.empty((0, 7)))
    """(p, 7) tracked people, each x, y in [m], velocity x, y in [m/s], and xx, xy, yy of the covariance in
    [m²].
    """
    snapshot: Pose2 | None = None
    """map_T_base at the start of the action, which a Fail restores."""


def seen_state(
    robot: Robot, evidence: Mapping[str, FloatArray], driven: list[Pose2], snapshot: Pose2 | None
) -> SeenState:
    """Copy the state of a robot that a run's node publishes.

    Args:
        robot: the robot, between two periods.
        evidence: (n, 2) points of the running action on the map, in [m], by name.
        driven: map_T_base since the action's start.
        snapshot: map_T_base at the action's start; None before the first action.
    """
    people = np.empty((0, 7))
    with suppress(Exception):  # primitives that need its readings report it
        people = People.of(robot.people.now(robot.time)).rows
    return SeenState(
        robot.pose,
        np.array(robot.localization.covariance),
        np.array(evidence.get("planned", NO_POINTS)).reshape(-1, 2),
        np.array([(pose.x, pose.y) for pose in driven]).reshape(-1, 2),
        np.array(robot.base.felt).reshape(-1, 2),
        people,
        snapshot,
    )


def action_state(number: int, action: Any, fails: int) -> dict[str, Any]:
    """Return the description of a starting action that is published for other programs.

    Args:
        number: number of the action in the run, from 1.
        action: the action of the network.
        fails: number of earlier Fails of the action.
    """
    given = {} if action.binding is None else action.binding.given()
    return {
        "number": number,
        "index": action.index,
        "do": action.do,
        "from": action.source,
        "to": action.target,
        "with": {key: str(value) for key, value in given.items()},
        "fails": fails,
        "state": "running",
    }
