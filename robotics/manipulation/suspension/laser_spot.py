"""A laser pointer on the base and its spot on a wall: how the paper measures yaw and pitch (section 5.1)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from handcart.robotics.geometry.transform import Transform, inverse

Floats = NDArray[np.float64]


class Rates(NamedTuple):
    """What angles tell of a `SuspensionModel`: all but the height of the pivot."""

    yaw_per_swing: float
    """In [rad]."""
    roll_per_m: float
    """In [rad/m]; 0 where no laser pointed sideways."""
    pitch_per_m: float
    """In [rad/m]; 0 where no laser pointed ahead."""


class SpotShift(NamedTuple):
    """How far the spot of a laser has moved on the wall since the reference posture, and after what."""

    reach: tuple[float, float]
    """How far the hand has moved along the base's x and y since then, in [m]."""
    swings: float
    """Moves out and back since then."""
    left: float
    """Of the spot along the wall, to the left as seen from the robot, in [m]."""
    up: float
    """Of the spot, in [m]."""


def spot_on_wall(world_T_base: Transform, base_T_laser: Transform, world_T_wall: Transform) -> Floats:
    """Where on the wall (2,) the spot is: (x, y) of the wall's frame in [m], whose plane is z = 0.

    The beam goes along the laser's x axis. Raises ValueError for a beam that doesn't meet the wall.
    """
    wall_T_laser = inverse(world_T_wall) @ world_T_base @ base_T_laser
    start, along = wall_T_laser[:3, 3], wall_T_laser[:3, 0]
    length = -start[2] / along[2] if along[2] != 0.0 else np.inf
    if not 0.0 < length < np.inf:
        raise ValueError("the beam doesn't meet the wall")
    return np.asarray((start + length * along)[:2])


def turned(shift: SpotShift, distance: float) -> tuple[float, float]:
    """How far the beam has turned to the left and up, in [rad], for a wall at right angles to it.

    `distance` [m] is from the pointer to the wall, as in the paper: that the pointer itself moves isn't seen.
    """
    return float(np.arctan2(shift.left, distance)), float(np.arctan2(shift.up, distance))


def fit_spots(ahead: Sequence[SpotShift], left: Sequence[SpotShift], distance: float) -> Rates:
    """The rates, by least squares, from spots of a laser that points ahead (+x) and of one to the left (+y).

    Either may be empty; the paper has the one to the left. Raises ValueError where hand and arm moved too
    little to tell a rate.
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
    """The slope of a line through the origin."""
    over, value = np.array(pairs, dtype=float).reshape(-1, 2).T
    if float(over @ over) < _LEAST_MOVED**2:
        raise ValueError(f"the spots can't tell {name}: move the hand further, or swing it more often")
    return float(over @ value / (over @ over))


_LEAST_MOVED = 0.05  # of all moves together: [m], or swings
