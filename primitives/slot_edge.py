"""The side of a slot, seen past a held book."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from robotics.geometry.transform import Transform
from robotics.perception.camera_model import CameraModel
from robotics.perception.label_finder import flat_view
from robotics.perception.spine_edges import falling_edges, strips_of, upright

M_PER_PX = 0.0003
HEIGHTS = (0.045, 0.160)  # [m] above the board: what is seen from the height at which a book goes in
SPINE, DARK = (
    (0.010, 0.002),
    (0.001, 0.005),
)  # [m] left and right of the side: where spine and slot are compared
DARKER = 0.65  # a slot's brightness, against the spine's


def slot_edge(
    image: NDArray[np.uint8],
    camera: CameraModel,
    camera_T_shelf: Transform,
    expected: float,
    within: float,
    mask: NDArray[np.bool_],
    dark: bool = True,
) -> float | None:
    """y in the shelf frame of a slot's left side, in [m]; None where no such side is seen.

    Args:
        image: (h, w).
        camera: that took it.
        camera_T_shelf: (4, 4).
        expected: y of the side as it was seen before, in [m].
        within: how far from there it may be, in [m].
        mask: (h, w), True where the image shows the shelf.
        dark: whether the slot must be darker than its neighbour, as it is between two books; at the end of
            the row a book end may be seen through it.
    """
    view = flat_view(image, camera, camera_T_shelf, mask, M_PER_PX, HEIGHTS)
    strips = upright(strips_of(view))
    sides = []
    for edge in falling_edges(strips):
        spine = strips.brightness(edge.y + SPINE[0], edge.y + SPINE[1], HEIGHTS[0])
        slot = strips.brightness(edge.y - DARK[0], edge.y - DARK[1], HEIGHTS[0])
        if not dark or (spine is not None and slot is not None and slot < DARKER * spine):
            sides.append(edge.y)
    near = [y for y in sides if abs(y - expected) < within]
    return min(near, key=lambda y: abs(y - expected), default=None)
