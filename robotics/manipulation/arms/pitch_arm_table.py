"""The closed form of `PitchArm`, compiled."""

from __future__ import annotations

import math

import numpy as np

from handcart.robotics.numerics.arrays import BoolArray, FloatArray, SingleArray
from handcart.robotics.numerics.compiled import compiled, compiled_for

from .score_rule import UNUSABLE_SCORE, worth
from .two_links import two_links


@compiled
def _pitches(
    ux: float, uz: float, vx: float, vz: float, cos: float, sin: float
) -> tuple[float, float, float]:
    """Angles of the three pitch joints from unit vectors along upper arm, forearm and tool."""
    return (
        math.atan2(uz, ux),
        math.atan2(ux * vz - uz * vx, ux * vx + uz * vz),
        math.atan2(vx * sin - vz * cos, vx * cos + vz * sin),
    )


@compiled
def _within(ux: float, uz: float, vx: float, vz: float, cos: float, sin: float, limits: FloatArray) -> bool:
    a, b, c = _pitches(ux, uz, vx, vz, cos, sin)
    return bool(limits[0] <= a <= limits[1] and limits[2] <= b <= limits[3] and limits[4] <= c <= limits[5])


@compiled_for("(f8[:,::1], f8[:,::1], f8[::1], i8, f8[:,::1])")
def pitch_arm_table(
    stands: FloatArray, marks: FloatArray, arm: FloatArray, measure: int, limits: FloatArray
) -> tuple[SingleArray, BoolArray]:
    """Return the scores (p, b) of a path's points for base poses, higher is better, and a mask (p, b).

    The mask is True where the arm reaches the point within its joint limits and within `limits`.

    Args:
        stands: (b, 4) x and y of the yaw axis in the world, in [m]; cosine and sine of the base's heading.
        marks: (p, 11) position in [m], tangent, level direction of the tool (2), all in the world, and
            cosine, sine and rate in [rad/m] of the tool's elevation; returned by `PitchArm.marks`.
        arm: (12,) shoulder height and three link lengths in [m]; cosines of the yaw limit and of the azimuth
            tolerance; lower and upper limit of each pitch joint in [rad].
        measure: what is scored, as a number of the enumeration `Measure`.
        limits: (3, 4) for the yaw joint and three pitch joints: rows `low` and `high` of a `ScoreRule`, which
            limit the lever of the tool's force about the joint, in [m], and 2 / (high - low), in [1/m].
    """
    height, l1, l2, l3 = arm[0], arm[1], arm[2], arm[3]
    cos_yaw, cos_azimuth, turns = arm[4], arm[5], arm[6:12]
    limited = np.isfinite(turns).any()
    values = np.zeros((len(marks), len(stands)), dtype=np.float32)
    usable = np.zeros((len(marks), len(stands)), dtype=np.bool_)
    elements, rates = np.empty(4), np.empty(4)
    for j in range(len(marks)):
        mark = marks[j]
        kx, ky, kz = mark[3], mark[4], mark[5]
        level_x, level_y = mark[6], mark[7]
        cos, sin, rate = mark[8], mark[9], mark[10]
        tip_z = mark[2] - height
        wrist_z = tip_z - l3 * sin
        inside = (l1 + l2) ** 2 - wrist_z**2
        if inside <= 0.0:
            continue
        farthest = math.sqrt(inside) + l3 * cos
        for b in range(len(stands)):
            x, y = mark[0] - stands[b, 0], mark[1] - stands[b, 1]
            squared = x * x + y * y
            if squared > farthest * farthest or squared == 0.0:
                continue
            distance = math.sqrt(squared)
            if level_x * x + level_y * y < cos_azimuth * distance:
                continue
            if stands[b, 2] * x + stands[b, 3] * y < cos_yaw * distance:
                continue
            wrist_r = distance - l3 * cos
            reached, ux, uz, vx, vz, bend = two_links(wrist_r, wrist_z, l1, l2, 1.0)
            if not reached or (limited and not _within(ux, uz, vx, vz, cos, sin, turns)):
                continue
            per_distance, per_bend = 1.0 / distance, 1.0 / -max(-bend, 1e-300)  # the elbow is up
            kt, kr = (ky * x - kx * y) * per_distance, (kx * x + ky * y) * per_distance
            elements[0] = abs(kt) * distance
            elements[1] = abs(kz * distance - kr * tip_z)
            elements[2] = abs(kz * (distance - l1 * ux) - kr * (tip_z - l1 * uz))
            elements[3] = l3 * abs(kz * cos - kr * sin)
            wrist_kr, wrist_kz = kr + rate * l3 * sin, kz - rate * l3 * cos
            upper = (wrist_kr * vx + wrist_kz * vz) * per_bend / l1
            fore = -(wrist_kr * ux + wrist_kz * uz) * per_bend / l2
            rates[0] = abs(kt) * per_distance
            rates[1], rates[2], rates[3] = abs(upper), abs(fore - upper), abs(rate - fore)
            value = worth(measure, elements, rates, distance * l1 * l2 * abs(bend), limits)
            if value != UNUSABLE_SCORE:
                values[j, b] = value
                usable[j, b] = True
    return values, usable


@compiled_for("(f8[::1], f8[:,::1], f8[::1])")
def pitch_arm_joints(stand: FloatArray, marks: FloatArray, arm: FloatArray) -> FloatArray:
    """Return the joint angles (p, 4), in [rad], for the points of a path: yaw, then the pitch joints.

    The angles are NaN for a point that is out of reach.

    Args:
        stand: (4,) x and y of the yaw axis in the world, in [m]; cosine and sine of the base's heading.
        marks: (p, 11) position in [m], tangent, level direction of the tool (2), all in the world, and
            cosine, sine and rate in [rad/m] of the tool's elevation; returned by `PitchArm.marks`.
        arm: (12,) shoulder height and three link lengths in [m]; cosines of the yaw limit and of the azimuth
            tolerance; lower and upper limit of each pitch joint in [rad].
    """
    angles = np.full((len(marks), 4), np.nan)
    for j in range(len(marks)):
        mark = marks[j]
        x, y = mark[0] - stand[0], mark[1] - stand[1]
        distance = math.hypot(x, y)
        ahead = stand[2] * x + stand[3] * y
        if distance == 0.0 or ahead < arm[4] * distance or mark[6] * x + mark[7] * y < arm[5] * distance:
            continue
        cos, sin = mark[8], mark[9]
        wrist_r, wrist_z = distance - arm[3] * cos, mark[2] - arm[0] - arm[3] * sin
        reached, ux, uz, vx, vz, _ = two_links(wrist_r, wrist_z, arm[1], arm[2], 1.0)
        if reached and _within(ux, uz, vx, vz, cos, sin, arm[6:12]):
            angles[j, 0] = math.atan2(stand[2] * y - stand[3] * x, stand[2] * x + stand[3] * y)
            angles[j, 1], angles[j, 2], angles[j, 3] = _pitches(ux, uz, vx, vz, cos, sin)
    return angles
