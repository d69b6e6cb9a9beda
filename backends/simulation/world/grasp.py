"""Grasp of a box or a cylinder by two closing pads."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from handcart.backends.simulation.world.thing import Thing
from handcart.backends.urdf.robot_shape import FingerShape
from handcart.robotics.geometry.transform import Transform, inverse
from handcart.robotics.numerics.arrays import FloatArray

PAD_FRICTION = 1.5  # Coulomb's coefficient of rubber pads; that of what they touch is multiplied with it
PAD_LENGTH_M = 0.05  # of the fingers' length that is padded, up to the tips [m]
MIN_BITE_M = 0.005  # a thing must reach this deep between the pads to be held [m]
_SQUARE = np.cos(np.radians(15.0))  # turned further than this against the pads, a box isn't gripped
_LENGTHWISE = np.cos(np.radians(45.0))  # between the pads and the axis of a cylinder that points along them


class Pads(NamedTuple):
    """Finger pads of a gripper: pose of the hand, opening between the pads, and shape of a finger."""

    world_T_hand: Transform
    """Pose world_T_hand (4, 4); the fingers close along the hand's y axis, and point along its x axis."""
    width: float
    """Opening between the pads, in [m]."""
    finger: FingerShape

    def outer(self) -> float:
        """Return the distance from the middle between the fingers to a finger's outer side, in [m]."""
        return self.width / 2 + self.finger.thickness


def thickness(thing: Thing, pads: Pads) -> float:
    """Return the thickness of a thing in the direction in which the finger pads close, in [m]."""
    return thing.size[_across(thing, pads)]


def fits(thing: Thing, pads: Pads) -> bool:
    """Return whether the fingers would grip a thing when they close: it is between the pads, within reach.

    The pads must meet two opposite sides of a box squarely; a cylinder may have any angle about its axis.
    """
    finger = pads.finger
    reach = np.array([PAD_LENGTH_M / 2, pads.outer(), finger.height / 2])
    middle = inverse(pads.world_T_hand) @ thing.pose @ thing.thing_T_middle
    axis = _across(thing, pads)
    half = np.abs(middle[:3, :3]) @ np.array(thing.size) / 2
    if thing.is_round:
        half = extent(middle[:3, 2], thing.size) / 2
    near = np.abs(middle[:3, 3] - (finger.tip - PAD_LENGTH_M / 2, 0.0, 0.0)) < reach + half - MIN_BITE_M
    inside = abs(middle[1, 3]) + thing.size[axis] / 2 < pads.outer()
    return bool(_squareness(thing, middle) > _SQUARE and near[0] and near[2] and inside)


def aside_at_pads(thing: Thing, pads: Pads) -> float:
    """Return how far a thing is to the left of the hand's middle where the pads grip, in [m].

    It is the y of the thing's middle line in the hand frame; negative to the right.
    """
    middle = inverse(pads.world_T_hand) @ thing.pose @ thing.thing_T_middle
    if thing.is_round and abs(float(middle[0, 2])) < _LENGTHWISE:
        return float(middle[1, 3])
    along = 2 if thing.is_round else int(np.argmax(np.abs(middle[0, :3])))
    half = abs(middle[0, along]) * thing.size[along] / 2
    ahead = np.clip(pads.finger.tip - PAD_LENGTH_M / 2 - middle[0, 3], -half, half)
    return float(middle[1, 3] + ahead * middle[1, along] / middle[0, along])


def hand_T_gripped(thing: Thing, pads: Pads) -> Transform:
    """Return hand_T_thing (4, 4) of a thing after the pads have closed on it.

    The thing turns until its sides are parallel to the pads, and its middle moves to the middle between the
    pads. It does not slide along the pads.
    """
    hand_T_middle = inverse(pads.world_T_hand) @ thing.pose @ thing.thing_T_middle
    side = _side(thing, hand_T_middle, _across(thing, pads))
    normal = np.array([0.0, np.sign(side[1]), 0.0])
    turn = Rotation.align_vectors(normal[None], side[None])[0].as_matrix()
    hand_T_middle[:3, :3] = turn @ hand_T_middle[:3, :3]
    hand_T_middle[1, 3] = 0.0
    return np.asarray(hand_T_middle @ inverse(thing.thing_T_middle))


def extent(axis: FloatArray, size: tuple[float, float, float]) -> FloatArray:
    """Return the size (3,) of a cylinder's bounding box along x, y and z of any frame, in [m].

    Args:
        axis: (3,) unit vector along the cylinder, in that frame.
        size: (3,) diameter, diameter and length of the cylinder, in [m].
    """
    return np.asarray(size[0] * np.sqrt(np.maximum(0.0, 1.0 - axis**2)) + size[2] * np.abs(axis))


def _squareness(thing: Thing, hand_T_middle: Transform) -> float:
    """Return the cosine between the closing direction and the normal of the side that the pads meet, 0 to 1.

    Args:
        thing: the thing.
        hand_T_middle: (4, 4) pose of the thing's middle in the hand frame.
    """
    along = abs(float(hand_T_middle[1, 2]))
    if thing.is_round:
        return max(along, float(np.sqrt(max(0.0, 1.0 - along**2))))
    return float(np.abs(hand_T_middle[1, :3]).max())


def _side(thing: Thing, hand_T_middle: Transform, across: int) -> FloatArray:
    """Return the unit normal (3,) of the side that the pads meet, in the hand frame.

    Args:
        thing: the thing.
        hand_T_middle: (4, 4) pose of the thing's middle in the hand frame.
        across: number of the thing's axis that is most parallel to the closing direction.
    """
    if not thing.is_round or across == 2:
        return np.asarray(hand_T_middle[:3, across])
    axis = hand_T_middle[:3, 2]
    radial = np.array([0.0, 1.0, 0.0]) - axis[1] * axis
    return np.asarray(radial / np.linalg.norm(radial))


def _across(thing: Thing, pads: Pads) -> int:
    """Return the number of the thing's axis that is most parallel to the closing direction; 0 or 2 if the
    thing is round.
    """
    if thing.is_round:
        return 2 if abs(float(pads.world_T_hand[:3, 1] @ thing.pose[:3, 2])) > _SQUARE else 0
    closing = pads.world_T_hand[:3, 1]
    return int(np.argmax(np.abs(thing.pose[:3, :3].T @ closing)))
