"""Surface of a box or a cylinder whose faces show parts of one picture."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from handcart.robotics.numerics.arrays import FloatArray

from .thing_form import BOX_FACES, BOX_NORMALS, Uvs

CYLINDER_STRIP_COUNT = 24  # of a cylinder's side; even
UPPER, LOWER = 4, 5  # numbers of the faces +z and -z


class FormMesh(NamedTuple):
    """Mesh of n quadrilaterals with normals and texture coordinates; corners counter-clockwise seen from
    outside.
    """

    corners: FloatArray
    """Corners (n, 4, 3) in [m], around the middle of the form."""
    normals: FloatArray
    """Unit normals (n, 3) of the quadrilaterals, outwards."""
    uvs: FloatArray
    """Places (n, 4, 2) of the corners in the picture: u to the right, v up, from 0 to 1."""


def form_mesh(size: Sequence[float], uvs: Sequence[Uvs], is_round: bool) -> FormMesh:
    """Return the surface of a box or cylinder as a mesh with texture coordinates.

    Args:
        size: (3,) lengths of the bounding box along x, y and z, in [m].
        uvs: four corners (u, v), 0 to 1, of each face in the texture; faces -x, +x, -y, +y, +z, -z.
        is_round: True for a cylinder along z.
    """
    half = np.array(size) / 2
    if not is_round:
        return FormMesh(BOX_FACES * half, BOX_NORMALS, np.array(uvs, dtype=np.float64))
    angles = np.arange(CYLINDER_STRIP_COUNT) * (2.0 * np.pi / CYLINDER_STRIP_COUNT)
    ring = np.column_stack([np.cos(angles), np.sin(angles)])
    following = np.roll(ring, -1, axis=0)
    low, high = np.full((CYLINDER_STRIP_COUNT, 1), -1.0), np.full((CYLINDER_STRIP_COUNT, 1), 1.0)
    sides = [np.hstack(item) for item in ((ring, low), (following, low), (following, high), (ring, high))]
    middles = (ring + following) / np.linalg.norm(ring + following, axis=1, keepdims=True)
    fan = np.array([(0, 2 * k + 1, 2 * k + 2, 2 * k + 3) for k in range((CYLINDER_STRIP_COUNT - 2) // 2)])
    ends = np.dstack([ring[fan], np.ones(fan.shape)])
    others = np.dstack([ring[fan[:, ::-1]], -np.ones(fan.shape)])
    corners = np.concatenate([np.stack(sides, axis=1), ends, others]) * half
    normals = np.concatenate(
        [
            np.column_stack([middles, np.zeros(CYLINDER_STRIP_COUNT)]),
            np.tile([0.0, 0.0, 1.0], (len(fan), 1)),
            np.tile([0.0, 0.0, -1.0], (len(fan), 1)),
        ]
    )
    plain = np.tile(np.array(uvs[0]).mean(axis=0), (CYLINDER_STRIP_COUNT, 4, 1))
    places = [plain, _on_end(ends, uvs[UPPER]), _on_end(others * (1.0, -1.0, 1.0), uvs[LOWER])]
    return FormMesh(corners, normals, np.concatenate(places))


def _on_end(points: FloatArray, uvs: Uvs) -> FloatArray:
    """Return the places (n, 4, 2), u and v, in the picture of points (n, 4, 3) on a cylinder's end.

    Args:
        points: (n, 4, 3); x and y from -1 to 1 across the end.
        uvs: corners of the end's face in the picture.
    """
    low, high = np.array(uvs[0]), np.array(uvs[2])
    return np.asarray(low + (points[..., :2] + 1.0) / 2 * (high - low))
