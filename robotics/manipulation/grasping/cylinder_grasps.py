"""Grasps of an upright cylinder by two parallel pads."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from .box_grasps import OPENING_MARGIN_M, TILTS_RAD, Grasp, hand_on

TURN_COUNT = 12  # of the hand about the axis that are tried, each
SIDE_TILTS_RAD = TILTS_RAD[:1] + TILTS_RAD[1::2]
"""Turns of an approach from aside, about the closing direction: level, then from above."""
AROUND_SIDE = "side"
"""Name of the side around the axis."""


def cylinder_grasps(
    diameter: float,
    height: float,
    opening: float,
    tip: float,
    towards: float = 0.0,
    above: bool = True,
    around: bool = True,
) -> Iterator[Grasp]:
    """Yield hand poses that grip an upright cylinder, vertical ones from above first.

    From above, the fingers close on the round side, in any direction. From the side, they close on the round
    side or on the two ends. Turns about the cylinder's axis begin at the direction to the robot.

    Args:
        diameter: diameter of the cylinder, in [m].
        height: height of the cylinder, in [m].
        opening: largest opening of the fingers, in [m].
        tip: distance from the frame `hand` to the finger tips, in [m].
        towards: azimuth of the direction to the robot in the frame of the cylinder, in [rad].
        above: True if the hand may come from above.
        around: True if the hand may come from around the axis.
    """
    size, widest = (diameter, diameter, height), opening - OPENING_MARGIN_M
    turns = [towards + turn for turn in np.arange(TURN_COUNT) * (2.0 * math.pi / TURN_COUNT)]
    turns.sort(key=lambda turn: abs(math.remainder(turn - towards, 2.0 * math.pi)))
    up = np.array([0.0, 0.0, 1.0])
    for tilt in TILTS_RAD if above and diameter <= widest else ():
        for turn in turns:
            closing = np.array([-math.sin(turn), math.cos(turn), 0.0])
            yield Grasp(hand_on(height, size[2], tip, up, closing, tilt), diameter, "+z", tilt)
    for tilt in SIDE_TILTS_RAD if around else ():
        for turn in turns:
            normal = np.array([math.cos(turn), math.sin(turn), 0.0])
            for sign in (1.0, -1.0):
                if diameter <= widest:
                    level = sign * np.array([-math.sin(turn), math.cos(turn), 0.0])
                    pose = hand_on(height, diameter, tip, normal, level, sign * tilt)
                    yield Grasp(pose, diameter, AROUND_SIDE, tilt)
                if height <= widest and tilt == 0.0:
                    pose = hand_on(height, diameter, tip, normal, sign * up, 0.0)
                    yield Grasp(pose, height, AROUND_SIDE, 0.0)
