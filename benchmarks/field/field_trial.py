"""One drive of a course with one way of localizing: how far from its targets are the sensors laid."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from benchmarks.field.field_drive import PERIOD_S
from benchmarks.field.field_log import FieldLog
from benchmarks.field.placement_radius import tip_covariance, tip_place
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.odometry.watched_moment import Belief
from handcart.robotics.navigation.outdoors.field_localizer import FieldLocalizer
from handcart.robotics.navigation.outdoors.gps_filter import GpsFilter
from handcart.robotics.numerics.arrays import BoolArray, FloatArray


class FieldTrial(NamedTuple):
    """Positions of laid sensors relative to their targets."""

    errors: FloatArray
    """(k, 2) in [m]: the arm goes where the target would be if the estimate were true."""
    covariances: FloatArray
    """(k, 2, 2) of them, as the robot believes, in [m²]."""
    consistent: BoolArray = np.ones(0, dtype=bool)
    """(k,) whether fixes didn't contradict that: elsewhere DEPLOY wouldn't lay."""


def start_pose(log: FieldLog) -> Pose2:
    """Return the pose that the robot assumes before the first reading."""
    return Pose2(0.0, 0.0, log.start_heading)


def try_course(log: FieldLog, localizer: FieldLocalizer) -> FieldTrial:
    """Play a log to a localizer that starts at `start_pose`."""
    fixes = dict(zip(log.fix_rows.tolist(), log.fixes, strict=True))
    placings = set(log.drive.placings.tolist())
    poses, covariances, consistent = [], [], []
    for row in range(max(placings) + 1):
        localizer.predict(log.rates[row], log.accelerations[row], log.wheels[row], PERIOD_S)
        if row in fixes:
            localizer.fix(fixes[row])
        if row in placings:
            if isinstance(localizer, GpsFilter):
                localizer.mark()
            poses.append(localizer.pose)
            covariances.append(localizer.covariance)
            consistent.append(localizer.inconsistency is None)
    return _trial(log, poses, covariances)._replace(consistent=np.array(consistent))


def as_laid(log: FieldLog, smoothed: list[Belief]) -> FieldTrial:
    """Return the same placements as the report after the drive gives them."""
    poses = [Pose2(*belief.mean[:3].tolist()) for belief in smoothed]
    return _trial(log, poses, [belief.covariance[:3, :3] for belief in smoothed])


def _trial(log: FieldLog, poses: list[Pose2], covariances: list[FloatArray]) -> FieldTrial:
    truth = [Pose2(*row.tolist()) for row in log.drive.poses[log.drive.placings]]
    errors = [tip_place(true) - tip_place(pose) for true, pose in zip(truth, poses, strict=True)]
    spreads = [tip_covariance(spread, pose.theta) for spread, pose in zip(covariances, poses, strict=True)]
    return FieldTrial(np.array(errors), np.array(spreads))
