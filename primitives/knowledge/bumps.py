"""Where the base ran into something that no sensor shows: noted, and kept off from then on."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from handcart.backends.description.robot_file import RobotFile
from handcart.backends.robot.robot import Robot
from handcart.primitives.contract.discrepancy import Discrepancy, Measured
from handcart.primitives.contract.evidence import Evidence
from handcart.robotics.navigation.following.blocked_motion import MAX_PROGRESS, Blocked
from handcart.robotics.navigation.maps.bump_area import bump_areas, bump_fronts

from .world_model import ModelView, WorldModel


def bump_here(robot: Robot, forwards: bool, heading: float | None = None) -> NDArray[np.float64]:
    """Return (3,) for `WorldModel.bumps`: the base does not get on where it is.

    `heading`, in [rad], is that with which it came; by default the one that it has.
    """
    turn = 0.0 if forwards else math.pi
    return np.array([robot.pose.x, robot.pose.y, (robot.pose.theta if heading is None else heading) + turn])


def keep_off_bumps(robot: Robot, model: WorldModel) -> None:
    """Have the base keep off every place where it ran into something."""
    robot.base.keep_off(bump_fronts(model.bumps, robot.spec.footprint_radius_m))


def note_bump(robot: Robot, model: WorldModel, evidence: Evidence) -> None:
    """Look whether the base was stopped in the last period; once a period.

    Raises:
        Discrepancy: it was; where, is in the world model from now on.
    """
    blocked = robot.blocked
    if blocked is None:
        return
    bump = bump_here(robot, blocked.forwards, blocked.heading)
    model.bumps = np.vstack([model.bumps, bump])
    keep_off_bumps(robot, model)
    evidence.points["bumped"] = bump_fronts(bump, robot.spec.footprint_radius_m)
    moved = Measured(
        "Base", "progress while driven", blocked.moved, MAX_PROGRESS * blocked.commanded, unit="m"
    )
    raise Discrepancy(_words(blocked, bump, robot.spec), measured=moved, check="contact")


def _words(blocked: Blocked, bump: NDArray[np.float64], spec: RobotFile) -> str:
    x, y = _touched(bump, spec.footprint_radius_m)
    there = f"at about ({x:.2f}, {y:.2f}) m"
    if blocked.slips:
        return f"the base ran into something that no sensor shows, {there}: its wheels turn, and it stands"
    return f"the base doesn't move, though it is driven: something stops it {there}, or its drives are off"


def avoided_points(spec: RobotFile, model: WorldModel | ModelView) -> NDArray[np.float64]:
    """Return (n, 2) points on the map in [m] to plan around: sensed, or run into."""
    return np.vstack([model.obstacles, bump_areas(model.bumps, spec.footprint_radius_m)])


def last_bump(spec: RobotFile, model: WorldModel | ModelView) -> tuple[float, float] | None:
    """Return the point in [m] about where the base last ran into something, or None."""
    return _touched(model.bumps[-1], spec.footprint_radius_m) if len(model.bumps) else None


def _touched(bump: NDArray[np.float64], radius: float) -> tuple[float, float]:
    x, y, direction = bump.tolist()
    return x + radius * math.cos(direction), y + radius * math.sin(direction)
