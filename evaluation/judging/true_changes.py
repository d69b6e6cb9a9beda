"""Changes between two instants by ground truth, and their limits."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping

import numpy as np

from handcart.backends.description.robot_file import RobotFile
from handcart.backends.ground_truth import Body, GroundTruth
from handcart.primitives.outcomes.residual import Residual, ResidualKind, Residuals
from handcart.robotics.geometry.transform import Transform, distance

from .sensor_sigmas import (
    BASE_SIGMA_DEG,
    BASE_SIGMA_MM,
    JOINT_SIGMA_DEG,
    LIMIT_SIGMAS,
    OBJECT_SIGMA_MM,
    SLIDE_SIGMA_MM,
)

GRIPPER_SIGMA_MM = 0.05  # of the measured opening
UNSURE_SHARE = 2.0  # fixed limit of the base, in tolerances: one known error and one unnoticed
STILL_LIMITS = {
    ResidualKind.BASE_POSITION: 0.5,
    ResidualKind.BASE_HEADING: 0.05,
    ResidualKind.JOINTS: 0.05,
    ResidualKind.SLIDING_JOINTS: 0.2,
    ResidualKind.GRIPPER: 0.2,
    ResidualKind.OBJECT: 1.0,
}
"""Largest change in two seconds of a scene at rest, in [mm] or [deg]."""
STILL_TURN_DEG = 0.5  # of a body in two seconds of a scene at rest
MOST_TURNED_DEG = 5.0  # of a body that was restored or is none of an action's business
"""Fixed: the end of a body 0.35 m long moves as far by it as `OBJECT` allows. Honest restoring turns less
than 0.5 deg.
"""


def moved(
    before: GroundTruth, after: GroundTruth, limits: Mapping[ResidualKind, float] = STILL_LIMITS
) -> Residuals:
    """Return how far base, joints, fingers and all bodies moved between two instants, with their limits.

    The motion of a body whose support changed is infinite.

    Args:
        before: ground truth at the first instant.
        after: ground truth at the second instant.
        limits: largest change of each kind, in [mm] or [deg]; the value of OBJECT is the limit of every body.
    """
    joints = np.abs(before.joints - after.joints)
    parts = {
        ResidualKind.BASE_POSITION: 1e3 * before.base.distance(after.base),
        ResidualKind.BASE_HEADING: math.degrees(before.base.turn(after.base)),
        ResidualKind.JOINTS: math.degrees(float(joints[~before.slides].max(initial=0.0))),
        ResidualKind.SLIDING_JOINTS: 1e3 * float(joints[before.slides].max(initial=0.0)),
        ResidualKind.GRIPPER: 1e3 * abs(before.width - after.width),
    }
    bodies = (
        Residual(
            ResidualKind.OBJECT, _way_mm(body, after.bodies.get(name)), limits[ResidualKind.OBJECT], name
        )
        for name, body in before.bodies.items()
    )
    return Residuals([*(Residual(kind, way, limits[kind]) for kind, way in parts.items()), *bodies])


def _way_mm(body: Body, now: Body | None) -> float:
    if now is None or now.support != body.support:
        return math.inf
    return 1e3 * distance(body.pose, now.pose)


def not_restored(
    before: GroundTruth,
    after: GroundTruth,
    spec: RobotFile,
    base_sigma: tuple[float, float] = (BASE_SIGMA_MM, BASE_SIGMA_DEG),
) -> list[str]:
    """Return a message for each part of the robot or body that a failed action did not restore to its start.

    The limit is the tolerance of the robot's file plus 5 standard deviations of the sensor. For the base, a
    fixed limit applies if it is smaller: twice the tolerance, or the tolerance plus 5 standard deviations of
    a scan match, whichever is more.

    Args:
        before: ground truth at the start of the action.
        after: ground truth after the failed action.
        spec: the robot's file, with the tolerances.
        base_sigma: standard deviation of the measured base motion, in [mm] and [deg].
    """
    tolerance = spec.tolerance
    allowed = {
        ResidualKind.BASE_POSITION: _base_limit(tolerance.base_mm, base_sigma[0], BASE_SIGMA_MM),
        ResidualKind.BASE_HEADING: _base_limit(tolerance.base_deg, base_sigma[1], BASE_SIGMA_DEG),
        ResidualKind.JOINTS: tolerance.joints_deg + LIMIT_SIGMAS * JOINT_SIGMA_DEG,
        ResidualKind.SLIDING_JOINTS: tolerance.slides_mm + LIMIT_SIGMAS * SLIDE_SIGMA_MM,
        ResidualKind.GRIPPER: tolerance.gripper_mm + LIMIT_SIGMAS * GRIPPER_SIGMA_MM,
        ResidualKind.OBJECT: tolerance.object_mm + LIMIT_SIGMAS * OBJECT_SIGMA_MM,
    }
    return _messages(moved(before, after, allowed)) + turned(before, after, MOST_TURNED_DEG)


def _base_limit(tolerance: float, sigma: float, of_scans: float) -> float:
    """Return the smaller one of two limits of the base's motion, in their unit; NaN for a sigma of NaN.

    Args:
        tolerance: tolerance of the robot's file.
        sigma: standard deviation of the measured motion.
        of_scans: standard deviation of a scan match, for the fixed limit.
    """
    fixed = max(UNSURE_SHARE * tolerance, tolerance + LIMIT_SIGMAS * of_scans)
    measured = tolerance + LIMIT_SIGMAS * sigma
    return measured if math.isnan(measured) else min(measured, fixed)


def not_still(before: GroundTruth, after: GroundTruth) -> list[str]:
    """Return a message for each part of the robot, and each other body, that moved although all should be at
    rest.
    """
    return _messages(moved(before, after)) + turned(before, after, STILL_TURN_DEG)


def disturbed(before: GroundTruth, after: GroundTruth, most_mm: float, without: Collection[str]) -> list[str]:
    """Return a text, with the motion in [mm], for each body that moved more than a limit.

    Args:
        before: ground truth at the first instant.
        after: ground truth at the second instant.
        most_mm: largest motion that is allowed, in [mm].
        without: names of bodies that may move.
    """
    ways = {name: _way_mm(body, after.bodies.get(name)) for name, body in before.bodies.items()}
    others = sorted(name for name in ways if name not in without)
    return [f"{name} mm {ways[name]:.1f}" for name in others if not ways[name] <= most_mm]


def turned(
    before: GroundTruth, after: GroundTruth, most_deg: float, without: Collection[str] = ()
) -> list[str]:
    """Return a message for each body that turned about any axis by more than a limit, on the same support.

    Args:
        before: ground truth at the first instant.
        after: ground truth at the second instant.
        most_deg: largest turn that is allowed, in [deg].
        without: names of bodies that may turn.
    """
    both = {
        name: (body, after.bodies[name])
        for name, body in sorted(before.bodies.items())
        if name in after.bodies and name not in without
    }
    turns = {
        name: _turn_deg(body.pose, now.pose)
        for name, (body, now) in both.items()
        if now.support == body.support
    }
    return [
        f"{name} deg {turn:.2f} (at most {most_deg:.2f})"
        for name, turn in turns.items()
        if not turn <= most_deg
    ]


def _turn_deg(one: Transform, other: Transform) -> float:
    """Return the angle between two orientations, in [deg]; NaN if one is unknown."""
    # The Frobenius norm of the difference is 2 sqrt(2) sin(angle / 2).
    share = float(np.linalg.norm(one[:3, :3] - other[:3, :3])) / math.sqrt(8.0)
    return math.degrees(2.0 * math.asin(min(1.0, share))) if share == share else math.nan


def _messages(changes: Residuals) -> list[str]:
    """Return a message for each change beyond its limit: `base mm 31.00 (at most 25.00)`."""
    return [
        f"{_name(change)} {change.value:.2f} (at most {change.limit:.2f})" for change in changes.beyond.all
    ]


def _name(change: Residual) -> str:
    return f"{change.name} mm" if change.kind is ResidualKind.OBJECT else change.label.replace("_", " ")
