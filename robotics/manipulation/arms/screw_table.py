"""Scores of an arm of screws over base poses and points of a path, compiled."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from handcart.robotics.numerics.arrays import BoolArray, FloatArray, IntArray, SingleArray
from handcart.robotics.numerics.compiled import Fields, compiled

from .score_rule import UNUSABLE_SCORE, worth
from .screw_chain import CHAIN_TYPES, ChainPosture, ScrewChain
from .screw_steps import descend, determinant_in_place, solve_in_place, tip_and_jacobian, without_free

_STARTS = 8  # postures of the pool that a descent is tried from
_ITERATIONS = 25
_WARM_ITERATIONS = 12
_JUMP = 0.5  # [rad] of a joint between two points of a path: another branch


class StartPool(NamedTuple):
    """Random joint postures of an arm, with their tip poses, at which inverse kinematics starts."""

    postures: FloatArray
    """(m, n) joint angles, in [rad]."""
    poses: FloatArray
    """(m, 4, 4) base_T_tip of each posture."""


class ToolTargets(NamedTuple):
    """Poses of a tool in the world at the points of its path, and its motion along the path."""

    poses: FloatArray
    """(p, 4, 4) world_T_tool."""
    twists: FloatArray
    """(p, 6) motion of the tool for each metre of path, in the axes of the world, [m/m] and [rad/m]."""


class ToolRule(NamedTuple):
    """Rule by which `screw_table` scores an arm at points of a path, with the tool's turn that is free."""

    free: int
    """1 if the tool's azimuth is free, 2 if its turn about its own x axis is free, 0 if neither is."""
    cos_tolerance: float
    """Cosine of the largest difference between the azimuths of tool and path, used with a free azimuth."""
    reach: float
    """Largest distance of the tool from the first joint's axis point, in [m]."""
    measure: int
    """Number of the `Measure`."""
    limits: FloatArray
    """(3, n) rows of the joints' low and high limits in [m], and of 2 / (high - low) in [1/m]."""


SCREW_TABLE_TYPES = (
    CHAIN_TYPES,
    Fields(StartPool, "(f8[:,::1], f8[:,:,::1])"),
    "f8[:,::1]",
    Fields(ToolTargets, "(f8[:,:,::1], f8[:,::1])"),
    Fields(ToolRule, "(i8, f8, f8, i8, f8[:,::1])"),
    "f8[:,:,::1]",
)
"""Numba's types of the arguments of `screw_table`, which takes half as long to compile as all others."""


@compiled
def pool_poses(chain: ScrewChain, pool: FloatArray) -> FloatArray:
    """Return base_T_tip (m, 4, 4) of m postures, the rows of `pool` (m, n): joint angles in [rad]."""
    poses = np.zeros((len(pool), 4, 4))
    jacobian = np.empty((6, pool.shape[1]))
    for index in range(len(pool)):
        poses[index, 3, 3] = 1.0
        tip_and_jacobian(chain, ChainPosture(pool[index], poses[index], jacobian))
    return poses


@compiled
def in_base(stand: FloatArray, world_T_tool: FloatArray, out: FloatArray) -> None:
    """Compute the pose base_T_tool (4, 4) of a tool from its pose in the world, and write it into `out`.

    Args:
        stand: (4,) x, y in the world in [m], cosine and sine of the heading of the base.
        world_T_tool: (4, 4) pose of the tool, translation in [m].
        out: (4, 4) base_T_tool, written.
    """
    cos, sin = stand[2], stand[3]
    for c in range(4):
        x, y = world_T_tool[0, c], world_T_tool[1, c]
        if c == 3:
            x, y = x - stand[0], y - stand[1]
        out[0, c], out[1, c] = cos * x + sin * y, cos * y - sin * x
        out[2, c], out[3, c] = world_T_tool[2, c], world_T_tool[3, c]


@compiled
def _turned(pose: FloatArray, target: FloatArray, free: int) -> float:
    """Return 2 - 2 cos of the turn between two poses, without a free turn: the turn's square if it is
    small.
    """
    if free == 0:
        trace = 0.0
        for i in range(3):
            for j in range(3):
                trace += pose[i, j] * target[i, j]
        return 3.0 - trace
    across = along = kept = 0.0
    for c in range(3):
        if free == 1:
            kept += pose[2, c] * target[2, c]
            across += pose[1, c] * target[0, c] - pose[0, c] * target[1, c]
            along += pose[0, c] * target[0, c] + pose[1, c] * target[1, c]
        else:
            kept += pose[c, 0] * target[c, 0]
            across += pose[c, 1] * target[c, 2] - pose[c, 2] * target[c, 1]
            along += pose[c, 1] * target[c, 1] + pose[c, 2] * target[c, 2]
    return 3.0 - kept - math.hypot(across, along)


@compiled
def nearest_starts(poses: FloatArray, target: FloatArray, free: int, scale: float, chosen: IntArray) -> None:
    """Find the k poses of an arm's tip that are nearest to a target; write their indices into `chosen`.

    Args:
        poses: (m, 4, 4) base_T_tip.
        target: (4, 4) wanted base_T_tip.
        free: 1 if the tool's azimuth is free, 2 if its turn about its own x axis is free, 0 if neither is.
        scale: distance that counts as much as a turn of one radian, in [m].
        chosen: (k,) row numbers in `poses`, written; the nearest comes first.
    """
    nearest = np.full(len(chosen), np.inf)
    for index in range(len(poses)):
        pose = poses[index]
        distance = scale * scale * _turned(pose, target, free)
        for r in range(3):
            distance += (target[r, 3] - pose[r, 3]) ** 2
        slot = len(chosen)
        while slot > 0 and distance < nearest[slot - 1]:
            slot -= 1
            if slot + 1 < len(chosen):
                nearest[slot + 1], chosen[slot + 1] = nearest[slot], chosen[slot]
        if slot < len(chosen):
            nearest[slot], chosen[slot] = distance, index


@compiled
def tool_rates(
    pose: FloatArray, jacobian: FloatArray, twist: FloatArray, free: int, rates: FloatArray
) -> float:
    """Write the joint motions for each metre of path into `rates`; return Yoshikawa's manipulability.

    The manipulability is 0 in a singular posture. For a redundant arm, the joint motion is that of least
    squares; with just one redundant joint, it is the motion whose largest joint rate is least.

    Args:
        pose: (4, 4) base_T_tip.
        jacobian: (6, n) in the axes of the base, three rows in [m/rad], then three in [rad/rad].
        twist: (6,) motion of the tool for each metre of path, in the axes of the base, [m/m] and [rad/m].
        free: 1 if the tool's azimuth is free, 2 if its turn about its own x axis is free, 0 if neither is.
        rates: (n,) in [rad/m], written.
    """
    n = len(rates)
    reduced, along = jacobian.copy(), twist.copy().reshape((6, 1))
    without_free(pose, free, reduced)
    without_free(pose, free, along)
    square = np.empty((6, 6))
    for r in range(6):
        for c in range(6):
            square[r, c] = _row_product(reduced, r, c)
    tasks = 6
    if free:
        tasks = 5
        axis = np.zeros(3)
        axis[2] = 1.0
        if free == 2:
            axis = pose[:3, 0].copy()
        for i in range(3):
            for j in range(3):
                square[3 + i, 3 + j] += axis[i] * axis[j]
    determinant = determinant_in_place(square.copy())
    if n < tasks or determinant < 1e-18:
        return 0.0
    right = along[:, 0].copy()
    if not solve_in_place(square.copy(), right):
        return 0.0
    for i in range(n):
        rates[i] = _column_product(reduced, i, right)
    if n == tasks + 1:
        _spread_evenly(reduced, square, rates)
    return math.sqrt(determinant)


@compiled
def _row_product(matrix: FloatArray, one: int, other: int) -> float:
    """Return the scalar product of two rows; written out because numba compiles `@` for half a second."""
    total = 0.0
    for k in range(matrix.shape[1]):
        total += matrix[one, k] * matrix[other, k]
    return total


@compiled
def _column_product(matrix: FloatArray, column: int, vector: FloatArray) -> float:
    """Return the scalar product of a column and a vector."""
    total = 0.0
    for k in range(len(vector)):
        total += matrix[k, column] * vector[k]
    return total


@compiled
def _largest_size(rates: FloatArray, amount: float, slope: FloatArray) -> float:
    """Return the largest size of `rates + amount * slope`."""
    largest = 0.0
    for i in range(len(rates)):
        largest = max(largest, abs(rates[i] + amount * slope[i]))
    return largest


@compiled
def _spread_evenly(reduced: FloatArray, square: FloatArray, rates: FloatArray) -> None:
    """Move along the one spare motion to where the largest rate is least: a linear program in one number."""
    n = len(rates)
    spare = np.eye(n)
    for column in range(n):
        right = reduced[:, column].copy()
        if not solve_in_place(square.copy(), right):
            return
        for i in range(n):
            spare[i, column] -= _column_product(reduced, i, right)
    widest = 0
    for i in range(n):
        if spare[i, i] > spare[widest, widest]:
            widest = i
    slope = spare[:, widest].copy()
    best, least = 0.0, np.inf
    for i in range(n):
        for j in range(i + 1, n):
            for sign in (-1.0, 1.0):
                bottom = slope[i] + sign * slope[j]
                if abs(bottom) > 1e-12:
                    amount = -(rates[i] + sign * rates[j]) / bottom
                    largest = _largest_size(rates, amount, slope)
                    if largest < least:
                        best, least = amount, largest
    if least < _largest_size(rates, 0.0, slope):
        for i in range(n):
            rates[i] += best * slope[i]


@compiled
def _within_azimuth(pose: FloatArray, target: FloatArray, cos_tolerance: float) -> bool:
    a = math.hypot(pose[0, 0], pose[1, 0])
    b = math.hypot(target[0, 0], target[1, 0])
    return bool(pose[0, 0] * target[0, 0] + pose[1, 0] * target[1, 0] >= cos_tolerance * a * b)


@compiled
def screw_table(
    chain: ScrewChain,
    pool: StartPool,
    stands: FloatArray,
    path: ToolTargets,
    rule: ToolRule,
    angles: FloatArray,
) -> tuple[SingleArray, BoolArray, BoolArray]:
    """Return the scores of the points of a path for base poses, by numerical inverse kinematics.

    The iteration for a point starts at the joints for the point before. At the first point, or if that
    iteration fails, iterations start at the nearest postures of the pool, and the best score of those that
    converge is taken.

    Args:
        chain: kinematics of the arm.
        pool: postures at which iterations start.
        stands: (b, 4) x, y in the world in [m], cosine and sine of the heading of the bases.
        path: path of the tool.
        rule: rule of the score.
        angles: (b, p, n) joint angles in [rad], written unless the array is empty.

    Returns:
        Scores (p, b); a mask (p, b), True where they are usable; and a mask (p-1, b), True where the arm
        moves to the next point without a jump of its joints.
    """
    p, bases, n = len(path.poses), len(stands), len(chain.axes)
    values = np.zeros((p, bases), dtype=np.float32)
    usable, joined = np.zeros((p, bases), dtype=np.bool_), np.zeros((p - 1, bases), dtype=np.bool_)
    target, twist, last, best = np.empty((4, 4)), np.empty(6), np.empty(n), np.empty(n)
    posture = ChainPosture(np.empty(n), np.eye(4), np.empty((6, n)))
    for b in range(bases):
        value = UNUSABLE_SCORE
        for j in range(p):
            in_base(stands[b], path.poses[j], target)
            _turn_twist(stands[b], path.twists[j], twist)
            before, value = value, UNUSABLE_SCORE
            if not _is_beyond_reach(chain.points, target, rule.reach):
                value = _best_score(chain, pool, target, twist, rule, before, posture, best)
            if value == UNUSABLE_SCORE:
                continue
            if before != UNUSABLE_SCORE:
                joined[j - 1, b] = _largest_step(best, last) <= _JUMP
            values[j, b], usable[j, b] = value, True
            _copy(best, last)
            if angles.size:
                _copy(best, angles[b, j])
    return values, usable, joined


@compiled
def _best_score(
    chain: ScrewChain,
    pool: StartPool,
    target: FloatArray,
    twist: FloatArray,
    rule: ToolRule,
    before: float,
    posture: ChainPosture,
    best: FloatArray,
) -> float:
    """Return the best score at a point of the path, and write its joint angles.

    Args:
        chain: kinematics of the arm.
        pool: postures where descents start.
        target: (4, 4) wanted base_T_tip.
        twist: (6,) motion of the tool for each metre of path, in the base frame, [m/m] and [rad/m].
        rule: rule of the score.
        before: score at the point before, whose angles `best` holds; if unusable, no descent starts there.
        posture: posture of the descents, written.
        best: (n,) in [rad], written.
    """
    largest, starts = UNUSABLE_SCORE, np.zeros(_STARTS, dtype=np.int64)
    for attempt in range(_STARTS + 1):
        iterations = _ITERATIONS
        if attempt == 0:
            if before == UNUSABLE_SCORE:
                continue
            iterations = _WARM_ITERATIONS
            _copy(best, posture.q)
        else:
            if attempt == 1:
                nearest_starts(pool.poses, target, rule.free, 0.3 * rule.reach, starts)
            _copy(pool.postures[starts[attempt - 1]], posture.q)
        if not descend(chain, target, rule.free, iterations, posture):
            continue
        if rule.free == 1 and not _within_azimuth(posture.pose, target, rule.cos_tolerance):
            continue
        value = _worth_here(posture, twist, rule)
        if value > largest:
            largest = value
            _copy(posture.q, best)
        if attempt == 0 and value != UNUSABLE_SCORE:
            break
    return largest


@compiled
def _is_beyond_reach(points: FloatArray, target: FloatArray, reach: float) -> bool:
    total = 0.0
    for r in range(3):
        total += (target[r, 3] - points[0, r]) ** 2
    return total > reach * reach


@compiled
def _turn_twist(stand: FloatArray, twist: FloatArray, out: FloatArray) -> None:
    """Write a twist (6,) of the world in the axes of a base into `out`."""
    cos, sin = stand[2], stand[3]
    for r in (0, 3):
        out[r] = cos * twist[r] + sin * twist[r + 1]
        out[r + 1] = cos * twist[r + 1] - sin * twist[r]
        out[r + 2] = twist[r + 2]


@compiled
def _copy(values: FloatArray, out: FloatArray) -> None:
    for i in range(len(values)):
        out[i] = values[i]


@compiled
def _largest_step(one: FloatArray, other: FloatArray) -> float:
    largest = 0.0
    for i in range(len(one)):
        largest = max(largest, abs(one[i] - other[i]))
    return largest


@compiled
def _worth_here(posture: ChainPosture, twist: FloatArray, rule: ToolRule) -> float:
    """Return the score of a posture."""
    jacobian, rates, levers = posture.jacobian, np.zeros(len(posture.q)), np.empty(len(posture.q))
    spread = tool_rates(posture.pose, jacobian, twist, rule.free, rates)
    if rule.measure != 0 and spread == 0.0:
        return UNUSABLE_SCORE
    for i in range(len(rates)):
        rates[i] = abs(rates[i])
        levers[i] = abs(twist[0] * jacobian[0, i] + twist[1] * jacobian[1, i] + twist[2] * jacobian[2, i])
    return worth(rule.measure, levers, rates, spread, rule.limits)
