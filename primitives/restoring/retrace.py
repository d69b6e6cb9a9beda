"""Playing a recorded motion backwards."""

from __future__ import annotations

import math
from collections.abc import Generator, Sequence
from itertools import pairwise

import numpy as np

from handcart.backends.robot.robot import Robot
from handcart.primitives.knowledge.world_model import WorldModel
from handcart.primitives.outcomes import causes
from handcart.primitives.outcomes.discrepancy import Discrepancy, Measured
from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.navigation.following.pose_regulator import PoseTolerance
from handcart.robotics.navigation.following.sideways_tracking import make_regulator, make_tracker
from handcart.robotics.navigation.maps.speed_limits import SpeedLimits
from handcart.robotics.numerics.arrays import FloatArray

from .arm_command import command_moment as _command
from .arm_command import renew_passed
from .car_retrace import car_retrace, check_stands
from .car_shunting import bring_back
from .pauses import Pauses
from .return_progress import HELD_RETURN_S, STUCK_RETURN_S, ReturnProgress
from .snapshot import Snapshot
from .trace import Moment, Trace

STRETCH_TOLERANCE = PoseTolerance(position=0.006, heading=0.004)
RETURN_TOLERANCE = PoseTolerance(position=0.003, heading=0.002)
POINT_SPACING_M = 0.02  # between points of the way back
MIN_TRACKED_TRAVEL_M = 0.05  # less travel than this is regulated, not tracked
EXACT_REACH_S = 10.0
"""Time that the base gets to reach a pose within the wanted tolerance, in [s]."""
WIDENING_S = 20.0
"""Time in which the tolerance grows to its largest value, after `EXACT_REACH_S`, in [s]."""
SPEEDS_UP = 4  # periods in which the first of an arm's steps is made; each of the next in one less
STANDSTILL_TOLERANCE = 1e-4  # [m], [rad]: between two periods, less is not motion


def retrace(
    robot: Robot, start: Snapshot, trace: Trace, allowed: SpeedLimits | None = None
) -> Generator[None, None, None]:
    """Bring the robot back to a snapshot along the path on which it came, base, arm and gripper in one
    sequence.

    Where the base moved, it is driven back with feedback of its pose, and the arm has at each pose the joints
    that it had there before. Between these parts, arm and gripper repeat their commands backwards. A car is
    brought back by `car_retrace`.

    Args:
        robot: robot at the end of the motion.
        start: snapshot to return to.
        trace: record of the motion.
        allowed: speed limits by place on the map; None: the base is limited by its drive alone.

    Raises:
        Discrepancy: the base does not get back.
    """
    if robot.spec.drive.kind == "ackermann":
        yield from car_retrace(robot, start, trace)
        return
    for stretch in reversed(_stretches(trace.moments)):
        if _travelled(stretch):
            yield from _drive_back(robot, stretch, allowed)
        else:
            yield from _play_back(robot, stretch)
    yield from _command(robot, Moment(start.pose, start.joint_command, start.gripper_command))
    yield from reach_pose(robot, start.pose, RETURN_TOLERANCE, HELD_RETURN_S)


def reach_pose(
    robot: Robot,
    goal: Pose2,
    tolerance: PoseTolerance = STRETCH_TOLERANCE,
    held_s: float = STUCK_RETURN_S,
) -> Generator[None, None, None]:
    """Bring the base to a close pose; do nothing if it is there already.

    The base is there if its position is within half of `tolerance`, and its heading within all of it. A base
    that shifts as it turns, such as a skid-steer base, may miss the pose by some millimetres. After
    `EXACT_REACH_S`, the tolerance is therefore widened, up to half of the tolerance in the robot's file. A
    car is not moved. Waits in which the motion is suspended count neither for the tolerance nor for the end
    after `STUCK_RETURN_S`.

    Args:
        robot: robot at rest near the pose.
        goal: map_T_base to reach.
        tolerance: largest difference from the goal.
        held_s: longest time with the time that obstacles or people hold the base, in [s].

    Raises:
        Discrepancy: the base does not reach the pose in time; or a car isn't within its tolerance.
    """
    if robot.spec.drive.kind == "ackermann":
        check_stands(robot, goal)
        return
    if robot.pose.distance(goal) < 0.5 * tolerance.position and robot.pose.turn(goal) < tolerance.heading:
        return
    regulator = make_regulator(goal, robot.drive_limits, tolerance)
    pauses, reaching = Pauses(robot), ReturnProgress(robot, held_s)
    while not regulator.finished(robot.pose):
        if pauses.has_ended():
            regulator.stopped()
        regulator.tolerance = _widened(robot, tolerance, reaching.driven_s)
        if reaching.is_over():
            off = robot.pose.distance(goal)
            away = Measured("Base", "distance from its goal", off, tolerance.position, "m")
            why = "" if robot.held is None else f": {robot.held.words}"
            raise Discrepancy(f"the base doesn't reach its pose{why}", measured=away, cause=causes.OFF_GOAL)
        robot.base.drive(*regulator.command(robot.pose, robot.period))
        yield


def _widened(robot: Robot, tolerance: PoseTolerance, passed: float) -> PoseTolerance:
    """Return the tolerance after a time in [s]: it grows evenly, up to half of what the file allows."""
    if passed <= EXACT_REACH_S:
        return tolerance
    share = min(1.0, (passed - EXACT_REACH_S) / WIDENING_S)
    allowed = robot.spec.tolerance
    most = PoseTolerance(0.5e-3 * allowed.base_mm, 0.5 * math.radians(allowed.base_deg))
    grown = zip(tolerance, most, strict=True)
    return PoseTolerance(*(exact + share * max(0.0, wide - exact) for exact, wide in grown))


def reach_again(robot: Robot, start: Snapshot, model: WorldModel, room: float) -> Generator[None, None, None]:
    """Bring the base from close by to the pose of a snapshot again.

    A base that can turn on the spot moves to the pose directly. A car waits until its displacement from the
    snapshot is known with an error below `room`, in [m]. If the displacement is larger than `room`, the car
    is moved back and forth until it is at the pose.
    """
    if robot.spec.drive.kind != "ackermann":
        yield from reach_pose(robot, start.pose, held_s=HELD_RETURN_S)
        return
    yield from bring_back(robot, start, model, room)


def _stretches(moments: Sequence[Moment]) -> list[list[Moment]]:
    """Return the moments, divided where the base starts or stops moving."""
    result: list[list[Moment]] = []
    moving = False
    for before, now in pairwise(moments):
        moves = (
            before.pose.distance(now.pose) > STANDSTILL_TOLERANCE
            or before.pose.turn(now.pose) > STANDSTILL_TOLERANCE
        )
        if not result or moves != moving:
            result.append([before])
        result[-1].append(now)
        moving = moves
    return result or [list(moments)]


def _travelled(stretch: Sequence[Moment]) -> bool:
    ends = stretch[0].pose, stretch[-1].pose
    return ends[0].distance(ends[1]) > 0.01 or ends[0].turn(ends[1]) > 0.02


def _drive_back(
    robot: Robot, stretch: Sequence[Moment], allowed: SpeedLimits | None
) -> Generator[None, None, None]:
    """Drive back along a stretch of the way, and bring the arm to the joints that it had at each place.

    Raises:
        Discrepancy: the base does not get on.
    """
    goal, left = stretch[0].pose, list(stretch)
    points, way = _way_back(stretch)
    if way[0] < MIN_TRACKED_TRAVEL_M:
        yield from reach_pose(robot, goal, held_s=HELD_RETURN_S)
    else:
        limits = robot.drive_limits
        tracker = make_tracker(points, goal.theta, limits, _forwards(stretch), STRETCH_TOLERANCE, allowed)
        pauses, getting_on = Pauses(robot), ReturnProgress(robot)
        while not tracker.finished(robot.pose):
            if pauses.has_ended():
                tracker.stopped()
            getting_on.check(tracker.progress)
            robot.base.drive(*tracker.command(robot.pose, robot.period))
            renew_passed(robot, left, way, tracker.progress)
            yield
    yield from _play_back(robot, left)


def _way_back(stretch: Sequence[Moment]) -> tuple[FloatArray, FloatArray]:
    """Return points (n, 2) from the end to the start, and the distance along them for each moment, in [m].

    Estimated poses jitter: points closer than `POINT_SPACING_M` would give a wrong direction.
    """
    ends = np.array([[moment.pose.x, moment.pose.y] for moment in reversed(stretch)])
    kept, along = [ends[0]], [0.0]
    for point in ends[1:]:
        step = float(np.hypot(*(point - kept[-1])))
        along.append(along[-1] + (step if step >= POINT_SPACING_M else 0.0))
        if step >= POINT_SPACING_M:
            kept.append(point)
    kept[1:] = [*kept[1:-1], ends[-1]]
    return np.array(kept), np.array(along)[::-1]


def _forwards(stretch: Sequence[Moment]) -> bool:
    """Return whether the base mostly drove forwards, so that the way back is driven backwards."""
    steps = [now.pose.relative_to(before.pose).x for before, now in pairwise(stretch)]
    return sum(steps) > 0.0


def _play_back(robot: Robot, stretch: Sequence[Moment]) -> Generator[None, None, None]:
    """Play the arm's motion back, slowly at first: a start at full speed would jerk the base, and its load
    would slide.
    """
    for number, moment in enumerate(reversed(stretch)):
        yield from _command(robot, moment, periods=max(1, SPEEDS_UP - number))
