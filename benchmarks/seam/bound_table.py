"""Upper bounds of directional scores over discs of shoulder positions, by intervals, compiled."""

from __future__ import annotations

import math

import numpy as np

from handcart.robotics.numerics.arrays import BoolArray, FloatArray, SingleArray
from handcart.robotics.numerics.compiled import compiled


@compiled
def _times(a: float, b: float, c: float, d: float) -> tuple[float, float]:
    """Interval of x y for x in [a, b] and y in [c, d]."""
    w, x, y, z = a * c, a * d, b * c, b * d
    return min(min(w, x), min(y, z)), max(max(w, x), max(y, z))


@compiled
def _least(low: float, high: float) -> float:
    """Least size of what lies in an interval."""
    if low <= 0.0 <= high:
        return 0.0
    return min(abs(low), abs(high))


@compiled
def _area(distance: float, first: float, second: float) -> float:
    """|first x second| where the wrist is that far away."""
    cos = (distance * distance - first * first - second * second) / (2.0 * first * second)
    return first * second * math.sqrt(max(0.0, 1.0 - cos * cos))


@compiled
def _in_frame(
    kr0: float, kr1: float, kz: float, wr0: float, wr1: float, wz: float, near: float, far: float
) -> tuple[float, float, float, float]:
    """Intervals of (kr, kz) along and across (to the left of) the line to the wrist (wr, wz)."""
    a0, a1 = _times(kr0, kr1, wr0, wr1)
    along0, along1 = _times(a0 + kz * wz, a1 + kz * wz, 1.0 / far, 1.0 / near)
    b0, b1 = min(kz * wr0, kz * wr1), max(kz * wr0, kz * wr1)
    c0, c1 = min(-kr0 * wz, -kr1 * wz), max(-kr0 * wz, -kr1 * wz)
    across0, across1 = _times(b0 + c0, b1 + c1, 1.0 / far, 1.0 / near)
    size = math.hypot(max(abs(kr0), abs(kr1)), kz)
    return max(along0, -size), min(along1, size), max(across0, -size), min(across1, size)


@compiled
def _room(value: float, low: float, high: float, least: float) -> float:
    """Upper side of eq. 6, no more than `value`."""
    return min(value, (high - least) / (0.5 * (high - low)))


@compiled
def _lift(fastest: float, low: float, high: float, most: float) -> float:
    """Lower side of eq. 6, no less than `fastest`."""
    return max(fastest, (most - low) / (0.5 * (high - low)))


@compiled
def bound_table(
    centres: FloatArray,
    radius: float,
    marks: FloatArray,
    arm: FloatArray,
    sure: bool,
    low: FloatArray,
    high: FloatArray,
) -> tuple[SingleArray, BoolArray]:
    """Return upper bounds (p, b) of the score of all shoulders in a disc, and True where any may be usable.

    Args:
        centres: (b, 2) centres of the discs, in [m].
        radius: radius of the discs, in [m].
        marks: (p, 9) position, tangent; the tool's level and upright parts, and its rate of elevation.
        arm: height, three links, 4 for yaw and pitches or 2 for a planar arm, and its elbow's side.
        sure: True if the speed margin counts.
        low: as in `ScoreRule`, in [m].
        high: as in `ScoreRule`, in [m].
    """
    height, l1, l2, l3, planar, side = arm[0], arm[1], arm[2], arm[3], arm[4] == 2.0, arm[5]
    gap = l2 * l2 - l1 * l1
    values = np.zeros((len(marks), len(centres)), dtype=np.float32)
    usable = np.zeros((len(marks), len(centres)), dtype=np.bool_)
    for j in range(len(marks)):
        kx, ky, kz = marks[j, 3], marks[j, 4], marks[j, 5]
        cos, sin, rate = marks[j, 6], marks[j, 7], marks[j, 8]
        tip_z = marks[j, 2] - height
        wz = tip_z - l3 * sin
        level = math.hypot(kx, ky)
        for b in range(len(centres)):
            x, y = marks[j, 0] - centres[b, 0], marks[j, 1] - centres[b, 1]
            distance = math.hypot(x, y)
            r0, r1 = max(distance - radius, 0.0), distance + radius
            wr0, wr1 = r0 - l3 * cos, r1 - l3 * cos
            near = max(math.hypot(_least(wr0, wr1), wz), max(abs(l1 - l2), 1e-9))
            far = min(math.hypot(max(abs(wr0), abs(wr1)), wz), l1 + l2)
            if near > far:
                continue
            turned = abs(ky * x - kx * y)
            turned0, turned1 = max(turned - level * radius, 0.0), turned + level * radius
            kr = (kx * x + ky * y) / max(distance, 1e-9)
            kt = (ky * x - kx * y) / max(distance, 1e-9)
            slack = level * radius / r0 if r0 > 0.0 else 2.0 * level
            kr0, kr1 = max(kr - slack, -level), min(kr + slack, level)
            kt0, kt1 = max(kt - slack, -level), min(kt + slack, level)
            area0 = min(_area(near, l1, l2), _area(far, l1, l2))
            area1 = max(_area(min(max(math.sqrt(l1 * l1 + l2 * l2), near), far), l1, l2), 1e-12)
            half0, half1 = side * area0 / far, side * area1 / near
            up0, up1 = min(half0, half1), max(half0, half1)
            end0, end1 = 0.5 * (near + gap / near), 0.5 * (far + gap / far)
            fore0, fore1 = min(end0, end1), max(end0, end1)
            if gap > 0.0 and near * near < gap < far * far:
                fore0 = math.sqrt(gap)
            # the tangent along and across the line to the wrist
            if planar:
                a0, a1, c0, c1 = kr0, kr1, kt0, kt1
            else:
                a0, a1, c0, c1 = _in_frame(kr0, kr1, kz, wr0, wr1, wz, near, far)
            value = _room(1.0, low[0], high[0], turned0)
            fastest = _lift(-np.inf, low[0], high[0], turned1)
            p0, p1 = _times(fore0, fore1, c0, c1)
            q0, q1 = _times(up0, up1, a0, a1)
            if planar:
                e0, e1 = p0 + q0, p1 + q1
                value = _room(value, low[1], high[1], _least(e0, e1))
                fastest = _lift(fastest, low[1], high[1], max(abs(e0), abs(e1)))
            else:
                d0, d1 = min(-kr0 * sin, -kr1 * sin), max(-kr0 * sin, -kr1 * sin)
                d0, d1 = l3 * (kz * cos + d0), l3 * (kz * cos + d1)
                e0, e1 = p0 + q0 + d0, p1 + q1 + d1
                value = _room(value, low[2], high[2], _least(e0, e1))
                fastest = _lift(fastest, low[2], high[2], max(abs(e0), abs(e1)))
                value = _room(value, low[3], high[3], _least(d0, d1))
                fastest = _lift(fastest, low[3], high[3], max(abs(d0), abs(d1)))
                g0, g1 = min(-kr0 * tip_z, -kr1 * tip_z), max(-kr0 * tip_z, -kr1 * tip_z)
                e0, e1 = min(kz * r0, kz * r1) + g0, max(kz * r0, kz * r1) + g1
                value = _room(value, low[1], high[1], _least(e0, e1))
                fastest = _lift(fastest, low[1], high[1], max(abs(e0), abs(e1)))
            value = min(value, fastest)
            if sure and value > 0.0:
                if not planar:
                    value = min(value, 1.0 - low[0] * turned0 / (r1 * r1))
                    if rate != 0.0:
                        shift = rate * l3
                        a0, a1, c0, c1 = _in_frame(
                            kr0 + shift * sin, kr1 + shift * sin, kz - shift * cos, wr0, wr1, wz, near, far
                        )
                p0, p1 = _times(fore0, fore1, a0, a1)
                q0, q1 = _times(up0, up1, c0, c1)
                upper = _least(p0 - q1, p1 - q0) / area1
                b0, b1 = _times(near, far, a0, a1)
                bend = _least(b0, b1) / area1
                first, elbow = (0, 1) if planar else (1, 2)
                value = min(value, min(1.0 - low[first] * upper, 1.0 - low[elbow] * bend))
                if not planar:
                    s0, s1 = 0.5 * (near - gap / near), 0.5 * (far - gap / far)
                    least, most = min(s0, s1), max(s0, s1)
                    if gap < 0.0 and near * near < -gap < far * far:
                        least = math.sqrt(-gap)
                    p0, p1 = _times(least, most, a0, a1)
                    q0, q1 = _times(up0, up1, c0, c1)
                    if area0 > 0.0:
                        t0, t1 = _times(p0 + q0, p1 + q1, 1.0 / area1, 1.0 / area0)
                        value = min(value, 1.0 - low[3] * _least(rate - side * t1, rate - side * t0))
            if value > 0.0:
                values[j, b] = np.float32(value * (1.0 + 1e-6))
                usable[j, b] = True
    return values, usable
