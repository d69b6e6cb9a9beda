"""Grasp of a box by two closing pads."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from handcart.backends.simulation.world.thing import Thing
from handcart.backends.urdf.robot_shape import FingerShape
from handcart.robotics.geometry.transform import Transform, inverse

PAD_LENGTH_M = 0.05  # of the fingers' length that is padded, up to the tips [m]
MIN_BITE_M = 0.005  # a thing must reach this deep between the pads to be held [m]
_SQUARE = np.cos(np.radians(15.0))  # turned further than this against the pads, a box isn't gripped


class Pads(NamedTuple):
    """Two fingers around a place."""

    world_T_hand: Transform
    """(4, 4); they close along y, and point along x."""
    width: float
    """Between them, in [m]."""
    finger: FingerShape

    def outer(self) -> float:
        """Return the distance from the middle to a finger's outer side, in [m]."""
        return self.width / 2 + self.finger.thickness


def thickness(thing: Thing, pads: Pads) -> float:
    """Return the thickness of a box between the pads, in [m]."""
    return thing.size[_across(thing, pads)]


def fits(thing: Thing, pads: Pads) -> bool:
    """Return whether closing pads meet a box squarely, on both sides."""
    finger = pads.finger
    reach = np.array([PAD_LENGTH_M / 2, pads.outer(), finger.height / 2])
    middle = inverse(pads.world_T_hand) @ thing.pose @ thing.thing_T_middle
    axis = _across(thing, pads)
    half = np.abs(middle[:3, :3]) @ np.array(thing.size) / 2
    near = np.abs(middle[:3, 3] - (finger.tip - PAD_LENGTH_M / 2, 0.0, 0.0)) < reach + half - MIN_BITE_M
    inside = abs(middle[1, 3]) + thing.size[axis] / 2 < pads.outer()
    return bool(abs(float(middle[1, axis])) > _SQUARE and near[0] and near[2] and inside)


def aside_at_pads(thing: Thing, pads: Pads) -> float:
    """Return the distance of a box's middle to the left of the hand's middle, at the pads, in [m]."""
    middle = inverse(pads.world_T_hand) @ thing.pose @ thing.thing_T_middle
    along = int(np.argmax(np.abs(middle[0, :3])))
    half = abs(middle[0, along]) * thing.size[along] / 2
    ahead = np.clip(pads.finger.tip - PAD_LENGTH_M / 2 - middle[0, 3], -half, half)
    return float(middle[1, 3] + ahead * middle[1, along] / middle[0, along])


def hand_T_gripped(thing: Thing, pads: Pads) -> Transform:
    """Return hand_T_thing (4, 4) of a thing between closed pads.

    Its sides align with the pads, and it slides between their middle; along the pads it stays.
    """
    hand_T_middle = inverse(pads.world_T_hand) @ thing.pose @ thing.thing_T_middle
    side = hand_T_middle[:3, _across(thing, pads)]
    normal = np.array([0.0, np.sign(side[1]), 0.0])
    turn = Rotation.align_vectors(normal[None], side[None])[0].as_matrix()
    hand_T_middle[:3, :3] = turn @ hand_T_middle[:3, :3]
    hand_T_middle[1, 3] = 0.0
    return np.asarray(hand_T_middle @ inverse(thing.thing_T_middle))


def _across(thing: Thing, pads: Pads) -> int:
    """Return the axis of a thing that is most parallel to the closing direction."""
    closing = pads.world_T_hand[:3, 1]
    return int(np.argmax(np.abs(thing.pose[:3, :3].T @ closing)))
