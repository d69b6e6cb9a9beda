"""Many boxes in the page as one node."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from handcart.robotics.numerics.arrays import ByteArray, FloatArray, SingleArray

from .colours import Rgb

if TYPE_CHECKING:
    import viser

# Each side has its own corners: shared corners would be shaded as a round surface.
_SIDE = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) / 2


def unit_box() -> tuple[SingleArray, NDArray[np.uint32]]:
    """Return corners (24, 3), in [m], and triangles (12, 3) of a cube around the origin with sides of 1 m."""
    corners: list[FloatArray] = []
    triangles: list[tuple[int, int, int]] = []
    for axis in range(3):
        for way in (-0.5, 0.5):
            first = len(corners)
            for u, v in _SIDE if way > 0 else _SIDE[::-1]:
                corner = np.empty(3)
                corner[axis], corner[(axis + 1) % 3], corner[(axis + 2) % 3] = way, u, v
                corners.append(corner)
            triangles += [(first, first + 1, first + 2), (first, first + 2, first + 3)]
    return np.array(corners, np.float32), np.array(triangles, np.uint32)


def add_boxes(
    scene: viser.SceneApi,
    name: str,
    poses: FloatArray,
    sizes: FloatArray,
    colours: Rgb | ByteArray,
    opacity: float,
) -> None:
    """Draw fixed boxes.

    Args:
        scene: viser's scene.
        name: name of the node.
        poses: (n, 7) world_T_box of their centres: x, y, z in [m], and a unit quaternion w, x, y, z.
        sizes: (n, 3) length, width and height, in [m].
        colours: one RGB colour for all, or (n, 3), from 0 to 255.
        opacity: 0 to 1.
    """
    if not len(poses):
        return
    corners, triangles = unit_box()
    scene.add_batched_meshes_simple(
        name,
        corners,
        triangles,
        batched_wxyzs=poses[:, 3:],
        batched_positions=poses[:, :3],
        batched_scales=sizes,
        batched_colors=colours,
        opacity=opacity if opacity < 1.0 else None,
        lod="off",
        flat_shading=True,
        cast_shadow=opacity == 1.0,
    )
