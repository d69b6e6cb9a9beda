"""Changes between two instants by ground truth, and their limits."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping

import numpy as np

from handcart.backends.description.robot_file import RobotFile
from handcart.backends.ground_truth import GroundTruth
from handcart.robotics.geometry.transform import distance

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
    "base mm": 0.5,
    "base deg": 0.05,
    "joints deg": 0.05,
    "slides mm": 0.2,
    "gripper mm": 0.2,
    "body mm": 1.0,
}
"""Largest change in two seconds of a scene at rest, by name with unit."""


def moved(before: GroundTruth, after: GroundTruth) -> dict[str, float]:
    """Return how far everything moved, by name with unit; infinity for a body whose support changed."""
    joints = np.abs(before.joints - after.joints)
    result = {
        "base mm": 1e3 * before.base.distance(after.base),
        "base deg": math.degrees(before.base.turn(after.base)),
        "joints deg": math.degrees(float(joints[~before.slides].max(initial=0.0))),
        "slides mm": 1e3 * float(joints[before.slides].max(initial=0.0)),
        "gripper mm": 1e3 * abs(before.width - after.width),
    }
    for name, body in before.bodies.items():
        now = after.bodies.get(name)
        lost = now is None or now.support != body.support
        result[f"{name} mm"] = math.inf if lost or now is None else 1e3 * distance(body.pose, now.pose)
    return result


def not_restored(
    before: GroundTruth,
    after: GroundTruth,
    spec: RobotFile,
    base_sigma: tuple[float, float] = (BASE_SIGMA_MM, BASE_SIGMA_DEG),
) -> list[str]:
    """Return a message for each quantity that is not restored within its limit.

    The limit is the tolerance of the robot's file plus 5 standard deviations of the sensor. The base has a
    fixed limit as well: twice its tolerance, or 5 standard deviations of a scan match beyond the tolerance
    if that is more.

    Args:
        before: ground truth at the start of the action.
        after: ground truth after the failed action.
        spec: the robot's file, with the tolerances.
        base_sigma: standard deviation of the measured base motion, in [mm] and [deg].
    """
    tolerance = spec.tolerance
    allowed = {
        "base mm": _base_limit(tolerance.base_mm, base_sigma[0], BASE_SIGMA_MM),
        "base deg": _base_limit(tolerance.base_deg, base_sigma[1], BASE_SIGMA_DEG),
        "joints deg": tolerance.joints_deg + LIMIT_SIGMAS * JOINT_SIGMA_DEG,
        "slides mm": tolerance.slides_mm + LIMIT_SIGMAS * SLIDE_SIGMA_MM,
        "gripper mm": tolerance.gripper_mm + LIMIT_SIGMAS * GRIPPER_SIGMA_MM,
    }
    body = tolerance.object_mm + LIMIT_SIGMAS * OBJECT_SIGMA_MM
    return _beyond(moved(before, after), allowed, body)


def _base_limit(tolerance: float, sigma: float, of_scans: float) -> float:
    """Return the smaller one of the measured and the fixed limit, in their unit; NaN for a sigma of NaN."""
    fixed = max(UNSURE_SHARE * tolerance, tolerance + LIMIT_SIGMAS * of_scans)
    measured = tolerance + LIMIT_SIGMAS * sigma
    return measured if math.isnan(measured) else min(measured, fixed)


def not_still(before: GroundTruth, after: GroundTruth) -> list[str]:
    """Return a message for each quantity that changed although the scene should be at rest."""
    return _beyond(moved(before, after), STILL_LIMITS, STILL_LIMITS["body mm"])


def disturbed(before: GroundTruth, after: GroundTruth, most_mm: float, without: Collection[str]) -> list[str]:
    """Return the bodies that moved more than `most_mm`, each with its motion in [mm], except those in
    `without`.
    """
    others = {f"{name} mm" for name in before.bodies if name not in without}
    found = moved(before, after)
    return [f"{name} {found[name]:.1f}" for name in sorted(others) if not found[name] <= most_mm]


def _beyond(found: Mapping[str, float], allowed: Mapping[str, float], body: float) -> list[str]:
    limits = {name: allowed.get(name, body) for name in found}
    return [
        f"{name} {size:.2f} (at most {limits[name]:.2f})"
        for name, size in found.items()
        if not size <= limits[name]
    ]
