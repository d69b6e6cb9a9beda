"""The landmark: a black square with one white corner field, on white paper."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from handcart.robotics.numerics.arrays import ByteArray, FloatArray
from handcart.robotics.perception.cameras.camera_model import CameraModel

CELLS_ACROSS = 8  # fields across the square
WHITE_FIELD = slice(1, 3)  # rows and columns of the white fields, from the upper left
PAPER, INK = 244, 22


class Landmark(NamedTuple):
    """Printed landmark as it was seen in an image.

    Its frame has the origin in the middle of the landmark, x to the right, y up, and z out of the paper. The
    white field of the print is at the upper left.
    """

    corners: FloatArray
    """(4, 2) in [px] of the image as taken: upper left, upper right, lower right, lower left."""
    centre: FloatArray
    """(2,) in [px] of the image as taken: where the diagonals meet."""
    rays: FloatArray
    """(4, 2) x/z and y/z of the same corners in the camera frame, without lens distortion."""
    angle: float
    """Angle from the camera's x to the landmark's, in [rad], -pi to pi; clockwise in the image positive."""
    score: float
    """Correlation of the square's inside with the landmark's pattern, 0 to 1."""


def draw_landmark(side: float = 0.06, margin: float = 0.01, m_per_px: float = 1.25e-4) -> ByteArray:
    """Return a printable sheet with a landmark as a grey image (n, n), whose side is `side` + 2 `margin`.

    Args:
        side: side of the landmark, in [m].
        margin: white margin around the landmark, in [m].
        m_per_px: size of a pixel, in [m].

    Raises:
        ValueError: a field or the margin is not a whole number of pixels, which would displace edges.
    """
    fields, border = side / CELLS_ACROSS / m_per_px, margin / m_per_px
    if any(abs(n - round(n)) > 1e-6 for n in (fields, border)) or round(fields) < 1:
        raise ValueError(
            f"a landmark of {side:g} m with a margin of {margin:g} m can't be drawn with {m_per_px:g} m a "
            f"pixel; side / {CELLS_ACROSS} and margin must be whole numbers of pixels"
        )
    ink = np.kron(pattern(), np.ones((round(fields), round(fields))))
    square = np.where(ink > 0, PAPER, INK).astype(np.uint8)
    return np.pad(square, round(border), constant_values=PAPER)


def pattern() -> FloatArray:
    """Return the pattern of the landmark, (8, 8) fields from the upper left: 1 white, 0 black."""
    fields = np.zeros((CELLS_ACROSS, CELLS_ACROSS))
    fields[WHITE_FIELD, WHITE_FIELD] = 1.0
    return fields


def square_corners(side: float) -> FloatArray:
    """Return the corners (4, 3) of a landmark in its own frame, in [m].

    They are in the order upper left, upper right, lower right, lower left; x is to the right, y up.

    Args:
        side: side of the landmark, in [m].
    """
    half = side / 2
    return np.array([[-half, half, 0.0], [half, half, 0.0], [half, -half, 0.0], [-half, -half, 0.0]])


def diagonals_meet(corners: FloatArray) -> FloatArray:
    """Return the point (2,) where the diagonals of a quadrangle (4, 2) meet, in its frame and unit."""
    a, b, c, d = corners
    along, across, start = c - a, d - b, b - a
    share = (start[0] * across[1] - start[1] * across[0]) / (along[0] * across[1] - along[1] * across[0])
    return np.asarray(a + share * along)


def seen_landmark(rays: FloatArray, camera: CameraModel, score: float) -> Landmark:
    """Return the landmark whose corners are on the given rays.

    Args:
        rays: (4, 2) rays to the upper left, upper right, lower right and lower left corner, x/z and y/z in
            the camera frame, without unit.
        camera: model of the camera.
        score: correlation of the square's inside with the landmark's pattern, 0 to 1.
    """
    both = np.vstack([rays, diagonals_meet(rays)])
    pixels = camera.project(np.column_stack([both, np.ones(5)]))
    right = rays[1] + rays[2] - rays[0] - rays[3]
    return Landmark(pixels[:4], pixels[4], rays, float(np.arctan2(right[1], right[0])), score)
