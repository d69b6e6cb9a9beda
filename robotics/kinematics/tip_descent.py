"""Inverse kinematics of an `ArmModel`, compiled: its joints as screws, and descents of its tip to a pose."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from handcart.robotics.kinematics.libraries import pin
from handcart.robotics.numerics.arrays import BoolArray, FloatArray, IntArray
from handcart.robotics.numerics.compiled import Fields, compiled, compiled_for
from handcart.robotics.numerics.small_solve import solved

MAX_ITERATIONS = 40
TOLERANCE = 1e-8  # [m] and [rad]
_LONGEST_STEP = 0.5  # [rad] or [m]
_DAMPING = 1e-7
_TINY = 1e-10  # [rad] below which a turn is its own sine


class TipScrews(NamedTuple):
    """Axes of the joints that move the tip of an arm, for forward kinematics as a product of exponentials.

    The axes are in the frame of the model's root, as in Lynch and Park, Modern Robotics (2017), chapter 4. Of
    the arm's n joints and their followers, k move the tip.
    """

    axes: FloatArray
    """(k, 3): unit vectors along the joints' axes, with all joints at zero."""
    points: FloatArray
    """(k, 3): a point on each axis, in [m]; of a joint that slides, zeros."""
    slides: BoolArray
    """(k,): True for joints that slide along their axis."""
    factors: FloatArray
    """(k, n): position of each of these joints for 1 rad or 1 m of each joint of the arm."""
    offsets: FloatArray
    """(k,): position of each of these joints with the arm's joints at zero, in [rad] or [m]."""
    root_T_tip: FloatArray
    """(4, 4): pose of the tip with all joints at zero."""
    lower: FloatArray
    """(n,): lower limits of the arm's joints, in [rad] or [m]; minus infinity if there is none."""
    upper: FloatArray
    """(n,): upper limits of the arm's joints, in [rad] or [m]; infinity if there is none."""


SCREW_TYPES = Fields(
    TipScrews, "(f8[:,::1], f8[:,::1], b1[::1], f8[:,::1], f8[::1], f8[:,::1], f8[::1], f8[::1])"
)


def tip_screws(
    model: pin.Model,
    tip_id: int,
    factors: FloatArray,
    offsets: FloatArray,
    limits: tuple[FloatArray, FloatArray],
) -> TipScrews:
    """Return the axes of those joints of a model of Pinocchio that move one of its frames, the arm's tip.

    Args:
        model: model whose joints have one degree of freedom each.
        tip_id: Pinocchio's index of the frame.
        factors: (m, n) positions of all joints for 1 rad or 1 m of each joint of the arm.
        offsets: (m,) positions of all joints with the arm's joints at zero, in [rad] or [m].
        limits: lower and upper limits (n,) of the arm's joints, in [rad] or [m].
    """
    data, zero = model.createData(), np.zeros(model.nq)
    twists = np.asarray(pin.computeJointJacobians(model, data, zero)).reshape(6, -1).copy()
    root_T_tip = pin.updateFramePlacement(model, data, tip_id).homogeneous
    joints = [joint for joint in model.supports[model.frames[tip_id].parentJoint] if joint > 0]
    rows = np.array([model.idx_vs[joint] for joint in joints], dtype=np.intp)
    velocities, turns = twists[:3, rows].T, twists[3:, rows].T
    slides = np.asarray(~turns.any(axis=1))
    return TipScrews(
        np.ascontiguousarray(np.where(slides[:, None], velocities, turns)),
        np.cross(turns, velocities),
        slides,
        np.ascontiguousarray(factors[rows]),
        offsets[rows],
        np.ascontiguousarray(root_T_tip),
        *(np.array(limit, dtype=np.float64) for limit in limits),
    )


@compiled
def _place_tip(screws: TipScrews, q: FloatArray, pose: FloatArray, jacobian: FloatArray) -> None:
    """Compute the tip's pose, and the motion of the tip by each of its k joints.

    Args:
        screws: joints that move the tip.
        q: (n,) positions of the arm's joints, in [rad] or [m].
        pose: (4, 4) root_T_tip, whose first three rows are written.
        jacobian: (6, k) speed and turn rate of the tip in its own axes for 1 rad/s or 1 m/s, written.
    """
    axes, points, tip = screws.axes, screws.points, screws.root_T_tip
    count = len(screws.slides)
    R, before, t = np.zeros((3, 3)), np.empty((3, 3)), np.zeros(3)
    directions, through = np.empty((count, 3)), np.empty((count, 3))
    R[0, 0] = R[1, 1] = R[2, 2] = 1.0
    for i in range(count):
        angle = screws.offsets[i]
        for j in range(len(q)):
            angle += screws.factors[i, j] * q[j]
        for r in range(3):
            directions[i, r] = R[r, 0] * axes[i, 0] + R[r, 1] * axes[i, 1] + R[r, 2] * axes[i, 2]
            through[i, r] = t[r] + R[r, 0] * points[i, 0] + R[r, 1] * points[i, 1] + R[r, 2] * points[i, 2]
        if screws.slides[i]:
            for r in range(3):
                t[r] += angle * directions[i, r]
            continue
        before, R = R, before
        _turn(before, axes[i], angle, R)
        for r in range(3):
            back = R[r, 0] * points[i, 0] + R[r, 1] * points[i, 1] + R[r, 2] * points[i, 2]
            t[r] = through[i, r] - back
    for r in range(3):
        pose[r, 3] = t[r] + R[r, 0] * tip[0, 3] + R[r, 1] * tip[1, 3] + R[r, 2] * tip[2, 3]
        for c in range(3):
            pose[r, c] = R[r, 0] * tip[0, c] + R[r, 1] * tip[1, c] + R[r, 2] * tip[2, c]
    for i in range(count):
        x, y, z = directions[i, 0], directions[i, 1], directions[i, 2]
        a, b, c = pose[0, 3] - through[i, 0], pose[1, 3] - through[i, 1], pose[2, 3] - through[i, 2]
        u, v, w = y * c - z * b, z * a - x * c, x * b - y * a
        if screws.slides[i]:
            u, v, w, x, y, z = x, y, z, 0.0, 0.0, 0.0
        for r in range(3):
            jacobian[r, i] = pose[0, r] * u + pose[1, r] * v + pose[2, r] * w
            jacobian[3 + r, i] = pose[0, r] * x + pose[1, r] * y + pose[2, r] * z


@compiled
def _turn(before: FloatArray, axis: FloatArray, angle: float, out: FloatArray) -> None:
    """Write the product of a rotation (3, 3) and a turn about an axis (3,) by an angle in [rad] into
    `out`.
    """
    s, c = math.sin(angle), math.cos(angle)
    d, x, y, z = 1.0 - c, axis[0], axis[1], axis[2]
    for r in range(3):
        a, b, e = before[r, 0], before[r, 1], before[r, 2]
        out[r, 0] = a * (c + d * x * x) + b * (d * x * y + s * z) + e * (d * x * z - s * y)
        out[r, 1] = a * (d * x * y - s * z) + b * (c + d * y * y) + e * (d * y * z + s * x)
        out[r, 2] = a * (d * x * z + s * y) + b * (d * y * z - s * x) + e * (c + d * z * z)


@compiled
def _turn_vector(R: FloatArray, out: FloatArray) -> float:
    """Write the rotation vector of R (3, 3) into `out` (3,), in [rad]; return its length, at most pi.

    It goes by the quaternion's largest component, so it holds for half a turn too: Shepperd (1978).
    """
    trace = R[0, 0] + R[1, 1] + R[2, 2]
    q = np.empty(4)
    largest = 3
    for i in range(3):
        if R[i, i] > (trace if largest == 3 else R[largest, largest]):
            largest = i
    if largest == 3:
        q[3] = 1.0 + trace
        q[0], q[1], q[2] = R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]
    else:
        i, j, k = largest, (largest + 1) % 3, (largest + 2) % 3
        q[i] = 1.0 + R[i, i] - R[j, j] - R[k, k]
        q[j], q[k] = R[j, i] + R[i, j], R[k, i] + R[i, k]
        q[3] = R[k, j] - R[j, k]
    sine = math.sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2])
    sign = -1.0 if q[3] < 0.0 else 1.0
    angle = 2.0 * math.atan2(sine, abs(q[3]))
    for r in range(3):
        out[r] = 2.0 * sign * q[r] / abs(q[3]) if sine < _TINY * abs(q[3]) else sign * angle * q[r] / sine
    return angle


@compiled
def _motion_to(pose: FloatArray, target: FloatArray, out: FloatArray) -> None:
    """Write the twist that moves a pose to a target in unit time, in the axes of the pose, into `out` (6,).

    It is the logarithm of the relative pose: speed in [m], then turn in [rad].
    """
    R, away, turn = np.empty((3, 3)), np.empty(3), np.empty(3)
    for r in range(3):
        away[r] = 0.0
        for k in range(3):
            away[r] += pose[k, r] * (target[k, 3] - pose[k, 3])
        for c in range(3):
            R[r, c] = pose[0, r] * target[0, c] + pose[1, r] * target[1, c] + pose[2, r] * target[2, c]
    angle = _turn_vector(R, turn)
    if angle < 1e-4:
        alpha, beta = 1.0 - angle * angle / 12.0, 1.0 / 12.0
    else:
        alpha = 0.5 * angle / math.tan(0.5 * angle)
        beta = (1.0 - alpha) / (angle * angle)
    along = beta * (turn[0] * away[0] + turn[1] * away[1] + turn[2] * away[2])
    out[0] = alpha * away[0] - 0.5 * (turn[1] * away[2] - turn[2] * away[1]) + along * turn[0]
    out[1] = alpha * away[1] - 0.5 * (turn[2] * away[0] - turn[0] * away[2]) + along * turn[1]
    out[2] = alpha * away[2] - 0.5 * (turn[0] * away[1] - turn[1] * away[0]) + along * turn[2]
    out[3], out[4], out[5] = turn[0], turn[1], turn[2]


@compiled_for((SCREW_TYPES, "f8[:,::1]", "f8[::1]"))
def descend(screws: TipScrews, root_T_target: FloatArray, q: FloatArray) -> bool:
    """Move an arm's joints until the tip is at a pose, within their limits; return whether that succeeded.

    The steps are damped least squares (Levenberg and Marquardt) whose damping falls with the remaining error:
    Sugihara (2011), eq. 15 and 16.

    Args:
        screws: joints that move the tip.
        root_T_target: (4, 4) wanted pose of the tip, translation in [m].
        q: (n,) start, in [rad] or [m]; the result is written into it.
    """
    n, count = len(q), len(screws.slides)
    pose, motions, error = np.empty((4, 4)), np.empty((6, count)), np.empty(6)
    J, H, g = np.empty((6, n)), np.empty((n, n)), np.empty((n, 1))
    for _ in range(MAX_ITERATIONS):
        _place_tip(screws, q, pose, motions)
        _motion_to(pose, root_T_target, error)
        squared = 0.0
        for r in range(6):
            squared += error[r] * error[r]
        if squared < TOLERANCE * TOLERANCE:
            return True
        for j in range(n):
            g[j, 0] = 0.0
            for r in range(6):
                J[r, j] = 0.0
                for i in range(count):
                    J[r, j] += motions[r, i] * screws.factors[i, j]
                g[j, 0] += J[r, j] * error[r]
            at_lower = q[j] <= screws.lower[j] and g[j, 0] < 0.0
            if at_lower or (q[j] >= screws.upper[j] and g[j, 0] > 0.0):
                g[j, 0] = 0.0
                for r in range(6):
                    J[r, j] = 0.0
        for i in range(n):
            for j in range(n):
                H[i, j] = 0.0
                for r in range(6):
                    H[i, j] += J[r, i] * J[r, j]
            H[i, i] += 0.05 * squared + _DAMPING
        step = solved(H, g)
        longest = 0.0
        for j in range(n):
            longest = max(longest, abs(step[j, 0]))
        if longest == 0.0:
            return False
        scale = min(1.0, _LONGEST_STEP / longest)
        for j in range(n):
            q[j] = min(max(q[j] + scale * step[j, 0], screws.lower[j]), screws.upper[j])
    return False


@compiled_for((SCREW_TYPES, "f8[:,::1]", "f8[:,:,::1]", "i8[::1]"))
def nearest_of_groups(
    screws: TipScrews, root_T_target: FloatArray, postures: FloatArray, best: IntArray
) -> None:
    """Find in each group of postures the one whose tip is nearest to a pose; write its index into `best`.

    In the distance between the tip and the pose, 1 rad of turn counts as 1 m.

    Args:
        screws: joints that move the tip.
        root_T_target: (4, 4) pose, translation in [m].
        postures: (groups, postures, n) in [rad] or [m].
        best: (groups,) integers, written.
    """
    pose, motions, error = np.empty((4, 4)), np.empty((6, len(screws.slides))), np.empty(6)
    for group in range(len(postures)):
        least = np.inf
        for number in range(postures.shape[1]):
            _place_tip(screws, postures[group, number], pose, motions)
            _motion_to(pose, root_T_target, error)
            squared = 0.0
            for r in range(6):
                squared += error[r] * error[r]
            if squared < least:
                least = squared
                best[group] = number
