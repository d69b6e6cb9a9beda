"""Grasps of a box by two parallel pads."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator
from typing import NamedTuple

import numpy as np

from handcart.robotics.geometry.transform import Transform
from handcart.robotics.numerics.arrays import FloatArray

OPENING_MARGIN_M = 0.004  # that the fingers open wider than what they close on
BITE_M = 0.030  # of the box that the pads cover, along the approach
MAX_BITE_SHARE = 0.6  # of the box's extent along the approach
TILTS_RAD = (0.0, math.radians(30.0), math.radians(-30.0), math.radians(55.0), math.radians(-55.0))
"""Turns of the approach about the closing direction."""


class Grasp(NamedTuple):
    """Pose of a hand that grips an object, in the frame of the object, and the width between its fingers."""

    box_T_hand: Transform
    """Pose (4, 4) of the hand, x along the approach, y along the closing direction.

    The origin of the box is in the middle of its foot, its axes along the sides.
    """
    width: float
    """Width of the box between the pads, in [m]."""
    face: str
    """Side that the hand comes from, by its outward normal: `+z` is from above."""
    tilt: float
    """Angle between the approach and the side's normal, in [rad]."""


def box_grasps(
    size: tuple[float, float, float], opening: float, tip: float, faces: Collection[str] | None = None
) -> Iterator[Grasp]:
    """Yield hand poses that grip a box; first those with the hand at a right angle to a side.

    The fingers close on two opposite sides of the box. The hand approaches one of the other sides, but not
    the bottom, at a right angle or tilted about the closing direction.

    Args:
        size: size of the box along its x, y and z, in [m].
        opening: largest opening of the fingers, in [m].
        tip: distance from the frame `hand` to the finger tips, in [m].
        faces: sides that the hand may approach, named by their normals such as `+z`; None for all.
    """
    for tilt in TILTS_RAD:
        for axis, sign, face in ((2, 1, "+z"), (0, -1, "-x"), (0, 1, "+x"), (1, -1, "-y"), (1, 1, "+y")):
            if faces is not None and face not in faces:
                continue
            for closing in (index for index in range(3) if index != axis and (axis == 2 or index != 2)):
                if size[closing] <= opening - OPENING_MARGIN_M:
                    for flip in (1, -1):
                        normal, across = sign * np.eye(3)[axis], flip * np.eye(3)[closing]
                        pose = hand_on(size[2], size[axis], tip, normal, across, tilt)
                        yield Grasp(pose, size[closing], face, tilt)


def hand_on(
    height: float, extent: float, tip: float, normal: FloatArray, closing: FloatArray, tilt: float
) -> Transform:
    """Return the pose box_T_hand (4, 4) at which the finger tips are `BITE_M` behind a side of a box.

    If the box is thin along the side's normal, the tips are less far behind the side.

    Args:
        height: height of the box, in [m].
        extent: extent of the box along the side's normal, in [m].
        tip: distance from the frame `hand` to the finger tips, in [m].
        normal: (3,) unit vector out of the side, in the frame of the box.
        closing: (3,) unit vector in which the pads close, in the frame of the box.
        tilt: turn of the approach about `closing`, in [rad].
    """
    bite = min(BITE_M, MAX_BITE_SHARE * extent)
    tips = np.array([0.0, 0.0, height / 2]) + normal * (extent / 2 - bite)
    across = np.cross(-normal, closing)
    ahead = -normal * math.cos(tilt) + across * math.sin(tilt)
    pose = np.eye(4)
    pose[:3, 0], pose[:3, 1], pose[:3, 2] = ahead, closing, np.cross(ahead, closing)
    pose[:3, 3] = tips - tip * ahead
    return pose
