"""A convex body that may touch others."""

from __future__ import annotations

from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from handcart.robotics.geometry.transform import Transform
from handcart.robotics.kinematics.coal_bodies import coal_body
from handcart.robotics.kinematics.fcl_bodies import fcl_body, touch
from handcart.robotics.kinematics.libraries import pin
from handcart.robotics.kinematics.shapes import Box, Shape

BARELY = 1e-9  # [m]


class RigidBody(NamedTuple):
    """A geometry twice: FCL judges whether it touches another one, coal measures how deep.

    Planners avoid contacts by coal. A fault of it can't hide what they then run into.
    """

    judging: object
    measuring: object

    @classmethod
    def of(cls, shape: Shape) -> Self:
        """About the origin of the shape's frame."""
        return cls(fcl_body(shape), coal_body(shape))

    @classmethod
    def box(cls, size: NDArray[np.float64]) -> Self:
        """A box of that size (3,) in [m] about its middle."""
        x, y, z = size.tolist()
        return cls.of(Box(np.eye(4), (x, y, z), ""))


def overlap(one: RigidBody, pose: Transform, other: RigidBody, other_pose: Transform) -> float:
    """How deep two bodies stand in each other at these poses (4, 4), in [m]; 0 where they don't touch."""
    if not touch(one.judging, pose, other.judging, other_pose):
        return 0.0
    request, result = pin.coal.CollisionRequest(), pin.coal.CollisionResult()
    if not pin.coal.collide(
        one.measuring, _placed(pose), other.measuring, _placed(other_pose), request, result
    ):
        return BARELY
    return max(BARELY, -float(result.getContact(0).penetration_depth))


def _placed(pose: Transform) -> object:
    return pin.coal.Transform3s(pose[:3, :3], pose[:3, 3])
