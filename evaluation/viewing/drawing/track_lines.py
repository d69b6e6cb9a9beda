"""Lines that show tracked people: an ellipse of three standard deviations, and where they are in a second."""

from __future__ import annotations

import numpy as np

from handcart.robotics.numerics.arrays import FloatArray

ELLIPSE_CORNERS = 24
ELLIPSE_SIGMAS = 3.0
MIN_RADIUS_M = 0.02


def track_lines(rows: FloatArray) -> list[FloatArray]:
    """Return two lines (n, 2) on the map, in [m], for each tracked person.

    These are the ellipse of the position's covariance, and the distance moved in one second.

    Args:
        rows: (p, 7) persons, each x, y on the map in [m], velocity x, y in [m/s], and xx, xy, yy of the
            position's covariance in [m²].
    """
    angle = np.linspace(0.0, 2.0 * np.pi, ELLIPSE_CORNERS + 1)
    unit, lines = np.stack((np.cos(angle), np.sin(angle))), []
    for x, y, vx, vy, xx, xy, yy in rows.tolist():
        values, vectors = np.linalg.eigh(np.array([[xx, xy], [xy, yy]]))
        radii = np.maximum(ELLIPSE_SIGMAS * np.sqrt(np.clip(values, 0.0, None)), MIN_RADIUS_M)
        lines.append(np.asarray((vectors @ (radii[:, None] * unit)).T + np.array([x, y])))
        lines.append(np.array([[x, y], [x + vx, y + vy]]))
    return lines
