"""Moving a held handle along a path that is estimated on the way."""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from enum import Enum
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from handcart.backends.robot.robot import Robot
from handcart.primitives.motions.felt_force import awaited_force
from handcart.primitives.motions.pushing import relax
from handcart.primitives.restoring.snapshot import settle
from handcart.robotics.geometry.transform import Transform
from handcart.robotics.manipulation.doors.path_fit import PathFit, PathPrior, fit_path
from handcart.robotics.numerics.arrays import FloatArray

from .base_drift import BaseDrift
from .stiffness import Stiffness

MAX_SPEED_M_S, MIN_SPEED_M_S = 0.02, 0.010  # of a hand that nothing resists, by how stiff the arm is
ACCELERATION_M_S2 = 0.03
GIVES_M_S_N = 0.0012  # speed with which the hand yields to a force across the path
GIVES_AT_REST_M_S_N = 0.00015  # likewise in any direction, as soon as the fingers have closed
MAX_GIVING_M_S = 0.02
MAX_PULL_N = 18.0  # resistance at which the hand stops
MAX_FORCE_N = 25.0  # in any direction
BLOCKED_TRAVEL_M = 0.001  # of the handle in so many periods: less, and it is blocked
BLOCKED_PERIODS = 24
OVER_PERIODS = 2  # above the maximum force
MAX_TURN_RATE_RAD_S = 0.4
POINT_SPACING_M = 0.002
POINT_SIGMA_M = 0.0004  # of the hand on the bar, by the joints
DAMPING = 1e-5  # of the inverse kinematics
SPEED_MARGIN = 0.8  # of a joint's top speed
MAX_LEAD_RAD = 0.04  # of a joint's command before its reading: less than what counts as not following
RELAX_PERIODS = 10
BIAS_PERIODS = 5


class PullEnding(Enum):
    """Reason why the motion of a door's handle by the hand ended."""

    REACHED = "reached"
    RESISTED = "resisted"
    """The handle does not go further with the allowed force."""
    OUT_OF_REACH = "out of reach"
    """The arm does not go further."""


class Pull(NamedTuple):
    """Result of moving a door's handle by the hand: its measured path, the largest force, and why the motion
    ended.
    """

    path: PathFit
    ending: PullEnding
    point: FloatArray
    """(3,) measured middle of the bar at the end, in the base frame, in [m]."""
    max_force: float
    """Largest measured force on the hand, in [N]."""


def measured_bar(robot: Robot, grip: FloatArray) -> FloatArray:
    """Return the middle (3,) of a held handle's bar in the base frame, by the measured joints, in [m].

    Args:
        robot: robot whose hand holds the handle.
        grip: (3,) middle of the bar in the frame of the hand, in [m].
    """
    return np.asarray((robot.base_T("hand") @ np.append(grip, 1.0))[:3])


def measured_bias(robot: Robot) -> Generator[None, None, FloatArray]:
    """Return the force (3,) that the sensor reports for an empty hand at rest, in the base frame, in [N]."""
    yield from settle(robot)
    forces: list[FloatArray] = []
    for _ in range(BIAS_PERIODS):
        forces.append((yield from _force(robot)))
        yield
    return np.asarray(np.mean(forces, axis=0))


def yield_to_force(robot: Robot, bias: FloatArray) -> Generator[None, None, None]:
    """Let a hand that has just closed on a handle give way to the force on the hand, for `RELAX_PERIODS`
    periods.

    Args:
        robot: robot whose hand holds a handle.
        bias: (3,) force that was measured on the empty hand before, in the base frame, in [N]; it is
            subtracted.
    """
    yield from relax(robot)
    for _ in range(RELAX_PERIODS):
        give = GIVES_AT_REST_M_S_N * ((yield from _force(robot)) - bias)
        _step(robot, np.concatenate([_at_most(give, MAX_GIVING_M_S), np.zeros(3)]))
        yield
    yield from relax(robot)


def pull(
    robot: Robot,
    grip: FloatArray,
    prior: PathPrior,
    is_there: Callable[[PathFit, FloatArray], bool],
    bias: FloatArray,
) -> Generator[None, None, Pull]:
    """Move a held handle along its path until it has moved far enough, resists, or is out of the arm's reach.

    The hand moves along the tangent of the path that fits all points measured so far, yields to forces across
    it, and turns with it.

    Args:
        robot: robot whose hand holds a handle.
        grip: (3,) middle of the handle's bar in the frame of the hand, in [m].
        prior: path expected before it is measured, in the base frame.
        is_there: function that returns whether the handle has moved far enough, given the measured path and
            the middle (3,) of the bar in the base frame, in [m].
        bias: (3,) force measured on the empty hand before, in the base frame, in [N], which is subtracted.
    """
    moved = BaseDrift(robot)
    yield from moved.begin()
    first = robot.arm_model.forward(robot.arm.command())
    points = [measured_bar(robot, grip)]
    path = fit_path(np.array(points), POINT_SIGMA_M, prior)
    speed, strongest, over = 0.0, 0.0, 0
    travels: list[float] = []
    stiffness = Stiffness(MAX_PULL_N, MAX_FORCE_N)
    ending, force = PullEnding.REACHED, (yield from _force(robot)) - bias
    while True:
        before, force = force, (yield from _force(robot)) - bias
        bar = measured_bar(robot, grip)
        moved.add(bar)
        if float(np.linalg.norm(bar - points[-1])) >= POINT_SPACING_M:
            points.append(bar)
            path = fit_path(np.array(points), POINT_SIGMA_M, prior)
        along = path.tangent(bar)
        resistance, size = float(-along @ force), float(np.linalg.norm(force))
        strongest = max(strongest, size)
        if is_there(path, bar):
            break
        over = over + 1 if size > MAX_FORCE_N else 0
        stiffness.add(speed * robot.period, resistance)
        easy = stiffness.step(resistance) / robot.period
        cruise = min(MAX_SPEED_M_S, max(MIN_SPEED_M_S, stiffness.sudden_step() / robot.period))
        in_lead = 4.0 * cruise * (1.0 - _lead(robot) / MAX_LEAD_RAD)
        allowed = min(cruise, max(-0.5 * cruise, min(easy, in_lead)))
        speed = min(allowed, max(0.0, speed) + ACCELERATION_M_S2 * robot.period)
        travels.append(path.travel(bar))
        if is_blocked(travels) or over >= OVER_PERIODS:
            ending = PullEnding.RESISTED
            break
        mean = (force + before) / 2.0  # a stiff arm that yields to each force alone swings
        gives = _at_most(GIVES_M_S_N * (mean - (mean @ along) * along), MAX_GIVING_M_S)
        turn = _turn_rate(robot, first, path.turned(bar))
        if not _step(robot, np.concatenate([speed * along + gives, turn])):
            ending = PullEnding.OUT_OF_REACH
            break
        yield
    yield from relax(robot)
    yield from settle(robot)
    bar = measured_bar(robot, grip)
    moved.add(bar)
    return Pull(fit_path(_apart(moved.points()), POINT_SIGMA_M, prior), ending, bar, strongest)


def is_blocked(travels: Sequence[float]) -> bool:
    """Return whether a handle has advanced by less than `BLOCKED_TRAVEL_M` in the last `BLOCKED_PERIODS`
    periods; False while there are fewer periods.

    Args:
        travels: travel of the handle along its path up to the end of each period, in [m].
    """
    return (
        len(travels) > BLOCKED_PERIODS
        and max(travels[-BLOCKED_PERIODS:]) - travels[-1 - BLOCKED_PERIODS] < BLOCKED_TRAVEL_M
    )


def _apart(points: FloatArray) -> FloatArray:
    """Return those (m, 3) of points (n, 3), in [m], that are `POINT_SPACING_M` apart; the first is
    included.
    """
    kept = [points[0]]
    for point in points[1:]:
        if float(np.linalg.norm(point - kept[-1])) >= POINT_SPACING_M:
            kept.append(point)
    return np.array(kept)


def _force(robot: Robot) -> Generator[None, None, FloatArray]:
    """Return the measured force (3,) on the hand, rotated into the base frame, in [N]."""
    force = yield from awaited_force(robot)
    return np.asarray(robot.base_T("hand")[:3, :3] @ force)


def _turn_rate(robot: Robot, first: Transform, turned: float) -> FloatArray:
    """Return the angular velocity (3,) in the base frame, in [rad/s], towards the first orientation turned by
    `turned`.

    Args:
        robot: robot whose commanded hand pose is used.
        first: (4, 4) base_T_hand at the begin of the pull.
        turned: turn of the path about the vertical since then, in [rad], positive to the left.
    """
    wanted = Rotation.from_euler("z", turned).as_matrix() @ first[:3, :3]
    now = robot.arm_model.forward(robot.arm.command())[:3, :3]
    off = Rotation.from_matrix(wanted @ now.T).as_rotvec()
    return _at_most(np.asarray(off / (2.0 * robot.period)), MAX_TURN_RATE_RAD_S)


def _step(robot: Robot, twist: FloatArray) -> bool:
    """Command a velocity of the hand for one period; return False at a joint's limit, without a command.

    Args:
        robot: robot with an arm.
        twist: (6,) linear velocity in [m/s], then angular velocity in [rad/s], in the base frame.
    """
    arm, here = robot.arm_model, robot.arm.command()
    J = arm.jacobian(here)
    rates = J.T @ np.linalg.solve(J @ J.T + DAMPING * np.eye(6), twist)
    most = SPEED_MARGIN * robot.joint_speeds
    rates /= max(1.0, float((np.abs(rates) / most).max()))
    goal = here + rates * robot.period
    if not arm.within(goal):
        return False
    robot.arm.move(goal)
    return True


def _lead(robot: Robot) -> float:
    """Return the largest distance of a joint from its command, in [rad], or [m] for a sliding joint."""
    return float(np.abs(robot.arm.command() - robot.arm.joints()).max())


def _at_most(vector: FloatArray, most: float) -> FloatArray:
    size = float(np.linalg.norm(vector))
    return vector if size <= most else np.asarray(vector * (most / size))
