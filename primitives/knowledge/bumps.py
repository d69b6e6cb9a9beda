"""Places where the base ran into an obstacle that no sensor shows, and how it keeps off them."""

from __future__ import annotations

import math

import numpy as np

from handcart.backends.capabilities.arm import Arm
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.robot.robot import Robot
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy, Measured
from handcart.primitives.outcomes.evidence import Evidence
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.kinematics.shapes import corners
from handcart.robotics.navigation.following.blocked_motion import MAX_PROGRESS, Blocked
from handcart.robotics.navigation.maps.bump_area import (
    FRONT_ANGLE_DEG,
    bump_areas,
    bump_fronts,
    leading_points,
)
from handcart.robotics.numerics.arrays import FloatArray

from .world_model import ModelView, WorldModel

ROOM_M = 0.05  # [m] beside the footprint where the base is, in which nothing is taken to be


def remember_bump(
    robot: Robot, model: WorldModel | ModelView, forwards: bool, blocked: Blocked | None = None
) -> FloatArray:
    """Record in the world model a bump, which is a contact of the base or its arm that has stopped the base.

    Args:
        robot: robot at the place where it was stopped, or to which it rebounded.
        model: world model to which the bump is added.
        forwards: True if the base was driven forwards.
        blocked: measurement by `BlockedMotion`; None if the bump was noticed otherwise.

    Returns:
        The row (3,) of `bumps`: x, y on the map in [m], direction of the motion in [rad].
    """
    pose, heading = robot.pose, robot.pose.theta
    if blocked is not None:
        now = robot.localization.odometry_pose
        pose, heading = pose.compose(blocked.pose.relative_to(now)), heading + blocked.heading - now.theta
    direction = heading + (0.0 if forwards else math.pi)
    bump = np.array([pose.x, pose.y, direction])
    model.bumps = np.vstack([model.bumps, bump])
    base_T_way = Pose2(0.0, 0.0, 0.0 if blocked is None else blocked.direction)
    outlines = [base_T_way.inverse().apply(outline) for outline in _arm_outlines(robot)]
    arm = pose.apply(base_T_way.apply(leading_points(outlines, forwards)))
    model.arm_bumps = np.vstack([model.arm_bumps, np.insert(arm, 2, direction, axis=1)])
    return bump


def _arm_outlines(robot: Robot) -> list[FloatArray]:
    """Return for each body of the arm, as measured, the points (k, 2) of its outline in the base frame, in
    [m].
    """
    arm = robot.backend.get(Arm)  # type: ignore[type-abstract]
    if arm is None:
        return []
    joints = arm.joints()
    if not np.isfinite(joints).all():
        return []
    return [corners(shape)[:, :2] for shape in robot.arm_model.moved_shapes(joints)]


def keep_off_bumps(robot: Robot, model: WorldModel, returns: bool = False) -> None:
    """Let the collision guard keep the base off all places where it or its arm ran into an obstacle.

    The guard slows down or stops the base's commands. The footprint's current place counts as free.

    Args:
        robot: the robot.
        model: world model with the bumps.
        returns: True while the base returns to its start. Then only the region straight ahead of each bump
            counts, because the base may have slid along the obstacle before.
    """
    radius = robot.spec.footprint_radius_m
    felt = bump_fronts(model.bumps, radius)
    if not returns:
        wide = np.vstack([bump_fronts(model.bumps, radius, FRONT_ANGLE_DEG), model.arm_bumps[:, :2]])
        felt = np.vstack([felt, _away(robot, wide)])
    robot.base.keep_off(felt)


def _away(robot: Robot, points: FloatArray) -> FloatArray:
    """Return those of points (n, 2), on the map in [m], that are outside the footprint at the base's current
    pose.
    """
    distance = robot.spec.footprint_shape.distances(robot.pose.inverse().apply(points))
    return np.asarray(points[distance > ROOM_M])


def note_bump(robot: Robot, model: WorldModel, evidence: Evidence) -> None:
    """Record a bump, which is a contact that stopped the base in the last period, and raise `Discrepancy`.

    Called once a period; without a bump it does nothing. If the robot's pose on the map is unknown, the bump
    is not kept in the model.

    Args:
        robot: the robot.
        model: world model to which the bump is added.
        evidence: evidence of the attempt, to which the place of the bump is added.
    """
    _check_wheels(robot)
    blocked = robot.progress.blocked
    if blocked is None:
        return
    known = model.bumps, model.arm_bumps
    bump = remember_bump(robot, model, blocked.forwards, blocked)
    if robot.localization.is_located:
        keep_off_bumps(robot, model, returns=True)
    else:  # its place on the map is unknown
        model.bumps, model.arm_bumps = known
    evidence.points["bumped"] = bump_fronts(bump, robot.spec.footprint_radius_m)
    moved = Measured(
        "Base", "progress while driven", blocked.moved, MAX_PROGRESS * blocked.commanded, unit="m"
    )
    raise Discrepancy(
        _words(blocked, bump, robot.spec), measured=moved, check="contact", cause=causes.BASE_STOPPED
    )


def _check_wheels(robot: Robot) -> None:
    """Raise `Discrepancy` if a wheel was driven in the last periods and the base did not get on there.

    Where the obstacle is remains unknown: it may be anywhere around the base.
    """
    found = robot.progress.blocked_wheel
    if found is None:
        return
    turns = "its wheels turn" if found.evidence.slips else "its wheels stand, or its drives are off"
    held = "it" if found.side == "both" else f"it at its {found.side} side"
    moved = Measured(
        "Base",
        f"progress of the {'wheels' if found.side == 'both' else f'{found.side} wheel'} while driven",
        found.evidence.moved,
        MAX_PROGRESS * found.evidence.commanded,
        unit="m",
    )
    raise Discrepancy(
        f"the base is driven and does not move so: something holds {held}"
        f" at ({found.pose.x:.2f}, {found.pose.y:.2f}) m, and {turns}",
        measured=moved,
        check="contact",
        cause=causes.BASE_STOPPED,
    )


def _words(blocked: Blocked, bump: FloatArray, spec: RobotFile) -> str:
    x, y = _touched(bump, spec.footprint_radius_m)
    there = f"at about ({x:.2f}, {y:.2f}) m"
    if blocked.slips:
        return f"the base ran into something that no sensor shows, {there}: its wheels turn, and it stands"
    return f"the base doesn't move, though it is driven: something stops it {there}, or its drives are off"


def avoided_points(robot: Robot, model: WorldModel | ModelView) -> FloatArray:
    """Return points (n, 2) on the map that routes must avoid, in [m]: sensed obstacles, and the places at
    which base or arm bumped into something.
    """
    arm = _away(robot, bump_areas(model.arm_bumps, 0.0))
    return np.vstack([model.obstacles, bump_areas(model.bumps, robot.spec.footprint_radius_m), arm])


def last_bump(spec: RobotFile, model: WorldModel | ModelView) -> tuple[float, float] | None:
    """Return the point (x, y) on the map, in [m], about where the base last hit something; None if it never
    did.
    """
    return _touched(model.bumps[-1], spec.footprint_radius_m) if len(model.bumps) else None


def _touched(bump: FloatArray, radius: float) -> tuple[float, float]:
    x, y, direction = bump.tolist()
    return x + radius * math.cos(direction), y + radius * math.sin(direction)
