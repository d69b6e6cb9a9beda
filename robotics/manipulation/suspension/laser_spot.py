"""A laser pointer on the base and its spot on a wall: how the paper measures yaw and pitch (section 5.1)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from handcart.robotics.geometry.transform import Transform, inverse
from handcart.robotics.numerics.arrays import FloatArray


class Rates(NamedTuple):
    """Parameters of a `SuspensionModel` that can be computed from measured angles, which are all except the
    height of the point about which the base tilts.
    """

    yaw_per_swing: float
    """Yaw of the base for each move of the arm out and back, in [rad], positive to the left."""
    roll_per_m: float
    """Roll of the base for each metre of the hand along +y, in [rad/m]; 0 without a laser to the left."""
    pitch_per_m: float
    """Pitch of the base for each metre of the hand along +x, in [rad/m]; 0 without a laser ahead."""


class SpotShift(NamedTuple):
    """Motion of a laser's spot on the wall since the reference posture, and the arm's motion that caused
    it.
    """

    reach: tuple[float, float]
    """Motion of the hand along the base's x and y since the reference posture, in [m]."""
    swings: float
    """Number of moves of the arm out and back since the reference posture."""
    left: float
    """Motion of the spot along the wall, to the left as seen from the robot, in [m]."""
    up: float
    """Upward motion of the spot, in [m]."""


def spot_on_wall(world_T_base: Transform, base_T_laser: Transform, world_T_wall: Transform) -> FloatArray:
    """Return the position (2,) of a laser's spot on a wall: x and y in the wall's frame, in [m].

    The beam points along the laser's x axis; the wall is the plane z = 0 of its frame.

    Args:
        world_T_base: (4, 4) pose of the base.
        base_T_laser: (4, 4) pose of the laser.
        world_T_wall: (4, 4) pose of the wall's frame.

    Raises:
        ValueError: the beam doesn't meet the wall.
    """
    wall_T_laser = inverse(world_T_wall) @ world_T_base @ base_T_laser
    start, along = wall_T_laser[:3, 3], wall_T_laser[:3, 0]
    length = -start[2] / along[2] if along[2] != 0.0 else np.inf
    if not 0.0 < length < np.inf:
        raise ValueError("the beam doesn't meet the wall")
    return np.asarray((start + length * along)[:2])


def turned(shift: SpotShift, distance: float) -> tuple[float, float]:
    """Return the turn of a laser's beam to the left and up, in [rad], computed from the shift of its spot.

    The wall is assumed to be at right angles to the beam. The laser's own motion is neglected, as in Hatano
    et al. (2000).

    Args:
        shift: motion of the spot on the wall, in [m].
        distance: distance from the laser to the wall, in [m].
    """
    return float(np.arctan2(shift.left, distance)), float(np.arctan2(shift.up, distance))


def fit_spots(ahead: Sequence[SpotShift], left: Sequence[SpotShift], distance: float) -> Rates:
    """Estimate how the base turns and tilts with the arm's motion, by least squares, from the spots of
    lasers.

    The results are the yaw for each swing of the arm, and roll and pitch for each metre of the hand's motion.
    The lasers are on the base and point ahead (+x) and left (+y).

    Spots of one of the lasers may be missing. Hatano et al. (2000) use only the laser that points to the
    left.

    Args:
        ahead: spots of the laser that points ahead.
        left: spots of the laser that points to the left.
        distance: distance from either laser to its wall, in [m].

    Raises:
        ValueError: hand and arm moved too little to fit a rate.
    """
    yaws = [(shift.swings, turned(shift, distance)[0]) for shift in (*ahead, *left)]
    # A beam ahead sinks with the front, one to the left rises with it.
    pitches = [(shift.reach[0], -turned(shift, distance)[1]) for shift in ahead]
    rolls = [(shift.reach[1], turned(shift, distance)[1]) for shift in left]
    return Rates(
        _slope("yaw_per_swing", yaws),
        _slope("roll_per_m", rolls) if left else 0.0,
        _slope("pitch_per_m", pitches) if ahead else 0.0,
    )


def _slope(name: str, pairs: Sequence[tuple[float, float]]) -> float:
    """Return the slope of a line through the origin."""
    over, value = np.array(pairs, dtype=float).reshape(-1, 2).T
    if float(over @ over) < _LEAST_MOVED**2:
        raise ValueError(f"the spots can't determine {name}: move the hand further, or swing it more often")
    return float(over @ value / (over @ over))


_LEAST_MOVED = 0.05  # of all moves together: [m], or swings
