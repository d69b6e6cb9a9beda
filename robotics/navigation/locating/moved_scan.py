"""An earlier scan of a base as its present beams would show it, by the motion of its wheels since."""

from __future__ import annotations

import math

import numpy as np

from handcart.robotics.geometry.pose2 import Pose2
from handcart.robotics.numerics.arrays import FloatArray
from handcart.robotics.numerics.compiled import compiled


def rolled_motion(left: float, right: float, sideways: float, tread: float) -> Pose2:
    """Return the motion before_T_after of a base by its wheels' travel.

    Args:
        left: travel of the left wheels, in [m].
        right: travel of the right wheels, in [m].
        sideways: travel to the left, in [m].
        tread: distance between the left and right wheels, in [m].
    """
    forward, turn = 0.5 * (left + right), (right - left) / tread
    cos, sin = math.cos(0.5 * turn), math.sin(0.5 * turn)
    return Pose2(forward * cos - sideways * sin, forward * sin + sideways * cos, turn)


@compiled
def same_ranges(one: FloatArray, other: FloatArray) -> bool:
    """Return whether all ranges are the same to the last bit; NaN is the same as NaN.

    Args:
        one: (n,) ranges of a scan, in [m].
        other: (m,) ranges of another scan, in [m].
    """
    if len(one) != len(other):
        return False
    for i in range(len(one)):
        if one[i] != other[i] and not (math.isnan(one[i]) and math.isnan(other[i])):
            return False
    return True


@compiled
def beam_step(angles: FloatArray) -> float:
    """Return the angle between neighbouring beams, in [rad]; 0 for a single beam.

    Args:
        angles: (n,) angles of the beams at even steps, in any one frame, in [rad].
    """
    count = len(angles)
    return (angles[count - 1] - angles[0]) / max(1, count - 1) if count else 0.0


@compiled
def moved_echoes(
    before: tuple[FloatArray, FloatArray, FloatArray], moved: tuple[float, float, float], sensor: FloatArray
) -> FloatArray:
    """Return the echoes (m, 2) of an earlier scan, relative to the sensor's present position, in [m].

    x and y are along the present axes of the base. A beam without an echo gives NaN.

    Args:
        before: origin (2,) in [m], angles (m,) in [rad] and ranges (m,) in [m] of the earlier scan, in the
            base frame at the time of that scan.
        moved: pose of the base at the earlier scan, in the present base frame: x, y in [m], heading in [rad].
        sensor: (2,) origin of the beams in the present base frame, in [m].
    """
    origin, rays, reaches = before
    cos, sin = math.cos(moved[2]), math.sin(moved[2])
    out = np.full((len(rays), 2), np.nan)
    for i in range(len(rays)):
        if not math.isfinite(reaches[i]):
            continue
        ahead = origin[0] + reaches[i] * math.cos(rays[i])
        left = origin[1] + reaches[i] * math.sin(rays[i])
        out[i, 0] = moved[0] + cos * ahead - sin * left - sensor[0]
        out[i, 1] = moved[1] + sin * ahead + cos * left - sensor[1]
    return out
