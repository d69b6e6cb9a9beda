"""Measured state at the start of a primitive, and the robot's later distance from it."""

from __future__ import annotations

import math
from collections.abc import Generator, Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from handcart.backends.capabilities.arm import Arm
from handcart.backends.capabilities.gripper import Gripper
from handcart.backends.description.robot_file import RobotFile
from handcart.backends.robot.localization.pose_covariance import worst_sigmas
from handcart.backends.robot.robot import Robot
from handcart.primitives.outcomes.residual import Residual, ResidualKind, Residuals
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.odometry.watched_moment import Belief
from handcart.robotics.numerics.arrays import FloatArray

RESIDUAL_SIGMAS = 3.0  # sigmas
REST_PERIODS = 5  # periods without any motion that count as rest
REST_TIMEOUT_S = 5.0
STALE_S = 6.0  # for which a lidar may repeat a scan: the base waits meanwhile for new ones
KNOWN_AGAIN = 20  # more of them until the pose of a base that was pushed is known again
JOINT_NOISE = 2e-4  # [rad] between two readings of a joint at rest
MIN_HELD_WIDTH_M = 0.002
"""Opening above which fingers that press on something hold it; below, they press on each other."""

Seen = Mapping[str, tuple[float, ...]]
"""Positions of objects, as last seen in the base frame in [m], by the objects' names."""


@dataclass(frozen=True)
class Snapshot:
    """Measured state of the robot at rest (base, arm, gripper, seen objects), for comparison with a later
    state.
    """

    pose: Pose2
    """map_T_base."""
    pose_sigma: tuple[float, float]
    """Sigma of the position in [m] and of the heading in [rad]."""
    joints: FloatArray
    """Measured joints (n,), in [rad] or [m]; (0,) without an arm."""
    joint_command: FloatArray
    """Commanded joints (n,), in [rad] or [m]."""
    gripper_command: float
    """Commanded width in [m]; 0 without a gripper."""
    gripper_width: float
    """Measured width, in [m]."""
    holding: bool
    """True if the fingers press on an object."""
    seen: Seen
    """Positions of the objects that the primitive can touch, in the base frame in [m]."""
    dead_reckoned: bool = False
    """True if only the wheels measured the base's motion."""
    odometry_pose: Pose2 | None = None
    """`Localization.odometry_pose` of the base, which does not jump; None if `pose` does not jump either."""
    displacement: Belief | None = None
    """Displacement of the base since the start of the attempt, if it is known better than its pose."""


def settle(robot: Robot) -> Generator[None, None, bool]:
    """Wait until the robot's readings are constant for `REST_PERIODS` and the pose of the base is known.

    Return whether that happened within `REST_TIMEOUT_S`. This time begins again while the lidar repeats a
    scan, for at most `STALE_S` in total.
    """
    still, end, displaced = 0, robot.time + REST_TIMEOUT_S, robot.localization.displacements
    latest = end + STALE_S
    before = _readings(robot)
    while still < REST_PERIODS and robot.time < end:
        yield
        now = _readings(robot)
        still = still + 1 if np.all(np.abs(now - before) <= JOINT_NOISE) else 0
        before = now
        if still == REST_PERIODS:
            robot.localization.look_again()
        if 0.0 < robot.localization.stale_s <= STALE_S:
            still, end = 0, min(robot.time + REST_TIMEOUT_S, latest)
        if robot.localization.displacements > displaced:
            displaced, still = robot.localization.displacements, -KNOWN_AGAIN
    return still >= REST_PERIODS


def take_snapshot(robot: Robot, seen: Seen) -> Snapshot:
    """Measure the robot's current state.

    Args:
        robot: robot at rest.
        seen: positions of the objects that the robot can touch; they are kept in the snapshot.
    """
    arm, gripper = robot.backend.get(Arm), robot.backend.get(Gripper)  # type: ignore[type-abstract]
    width = gripper.width() if gripper else 0.0
    where = robot.localization
    return Snapshot(
        pose=robot.pose,
        pose_sigma=where.sigma,
        joints=arm.joints().copy() if arm else np.empty(0),
        joint_command=arm.command().copy() if arm else np.empty(0),
        gripper_command=gripper.command() if gripper else 0.0,
        gripper_width=width,
        holding=is_holding(robot),
        seen=dict(seen),
        dead_reckoned=where.dead_reckoned,
        odometry_pose=where.odometry_pose if where.POSE_JUMPS else None,
    )


def is_holding(robot: Robot) -> bool:
    """Return whether the fingers press on an object, which keeps them apart."""
    gripper = robot.backend.get(Gripper)  # type: ignore[type-abstract]
    return bool(gripper and gripper.closed_on_something() and gripper.width() > MIN_HELD_WIDTH_M)


def take_snapshot_since_start(robot: Robot, seen: Seen) -> Snapshot:
    """Measure the robot's current state, including the base's displacement since the last call of
    `Localization.set_origin`.
    """
    return replace(take_snapshot(robot, seen), displacement=robot.localization.displacement)


def residuals(start: Snapshot, now: Snapshot, spec: RobotFile, room: float = math.inf) -> Residuals:
    """Return the differences (residuals) between two measured states of the robot, with the limits of the
    robot's file.

    The residual of a missing or lost object is infinite. For the base there is also the size of a motion that
    may have gone unnoticed: 3 sigma of the measurement.

    Args:
        start: earlier state.
        now: current state.
        spec: the robot's file, with its tolerances and joints.
        room: largest allowed distance of the base from its earlier pose, in [m]; if the tolerance in the
            robot's file is smaller, that tolerance is the limit.
    """
    tolerance, (away, turned), sigmas = spec.tolerance, _apart(start, now), _unsure(start, now)
    base_mm = min(tolerance.base_mm, 1e3 * room)
    angle, length = (RESIDUAL_SIGMAS * sigma for sigma in reversed(sigmas))
    lost = math.inf if start.holding != now.holding else 0.0
    return Residuals(
        [
            Residual(ResidualKind.BASE_POSITION, 1e3 * away, base_mm),
            Residual(ResidualKind.BASE_HEADING, math.degrees(turned), tolerance.base_deg),
            Residual(ResidualKind.BASE_POSITION_UNCERTAINTY, 1e3 * length, base_mm),
            Residual(ResidualKind.BASE_HEADING_UNCERTAINTY, math.degrees(angle), tolerance.base_deg),
            Residual(
                ResidualKind.GRIPPER, 1e3 * abs(now.gripper_width - start.gripper_width), tolerance.gripper_mm
            ),
            Residual(ResidualKind.HELD, lost, 0.0),
            *_of_joints(start, now, spec),
            *_of_objects(start, now, tolerance.object_mm),
        ]
    )


def _of_joints(start: Snapshot, now: Snapshot, spec: RobotFile) -> Iterator[Residual]:
    """Yield the largest change of the rotating joints and of the sliding ones; a full turn of a continuous
    joint does not count.
    """
    slides, endless = (np.array(unit, dtype=bool) for unit in spec.joint_units[1:])
    off = np.abs(now.joints - start.joints)
    if endless.any():
        off = np.where(endless, np.abs(np.remainder(off + math.pi, 2.0 * math.pi) - math.pi), off)
    if not slides.all():
        turned = math.degrees(float(off[~slides].max()))
        yield Residual(ResidualKind.JOINTS, turned, spec.tolerance.joints_deg)
    if slides.any():
        yield Residual(ResidualKind.SLIDING_JOINTS, 1e3 * float(off[slides].max()), spec.tolerance.slides_mm)


def _of_objects(start: Snapshot, now: Snapshot, limit_mm: float) -> Iterator[Residual]:
    for name, place in start.seen.items():
        away = math.dist(place, now.seen[name]) if name in now.seen else math.inf
        yield Residual(ResidualKind.OBJECT, 1e3 * away, limit_mm, name)


def _apart(start: Snapshot, now: Snapshot) -> tuple[float, float]:
    """Return the base's distance from its earlier position in [m], and its turn in [rad].

    A pose that jumps because its sensors learn counts only as far as wheels or gyros measured the motion,
    or as far as the jump exceeds its earlier uncertainty.
    """
    if now.displacement is not None:
        x, y, turn = now.displacement.mean.tolist()
        return math.hypot(x, y), abs(turn)
    by_pose = now.pose.distance(start.pose), now.pose.turn(start.pose)
    if now.odometry_pose is None or start.odometry_pose is None:
        return by_pose
    felt = now.odometry_pose.distance(start.odometry_pose), now.odometry_pose.turn(start.odometry_pose)
    off = [RESIDUAL_SIGMAS * math.hypot(*both) for both in zip(start.pose_sigma, now.pose_sigma, strict=True)]
    return max(felt[0], by_pose[0] - off[0]), max(felt[1], by_pose[1] - off[1])


def _unsure(start: Snapshot, now: Snapshot) -> tuple[float, float]:
    """Return sigma of the distance of two poses, in the worst direction in [m], and of the turn in [rad]."""
    if now.displacement is not None and math.isfinite(now.pose_sigma[0]):
        return worst_sigmas(now.displacement.covariance)
    if not now.dead_reckoned:
        position, heading = map(math.hypot, start.pose_sigma, now.pose_sigma)
        return position, heading
    added = [
        math.sqrt(max(0.0, late**2 - early**2))
        for late, early in zip(now.pose_sigma, start.pose_sigma, strict=True)
    ]
    return added[0], added[1]


def _readings(robot: Robot) -> FloatArray:
    arm, gripper = robot.backend.get(Arm), robot.backend.get(Gripper)  # type: ignore[type-abstract]
    return np.concatenate(
        [
            robot.base.wheel_travel(),
            arm.joints() if arm else np.empty(0),
            [gripper.width()] if gripper else np.empty(0),
        ]
    )
