"""Inverse kinematics of two links in a plane, for inner loops."""

from __future__ import annotations

import math

from handcart.robotics.numerics.compiled import compiled


@compiled
def two_links(
    x: float, y: float, first: float, second: float, side: float
) -> tuple[bool, float, float, float, float, float]:
    """Return unit vectors along the two links of a planar arm whose tip is at (x, y).

    Args:
        x: coordinate of the goal, in [m].
        y: coordinate of the goal, in [m].
        first: length of the first link, in [m].
        second: length of the second link, in [m].
        side: 1 for an elbow to the left of the line to (x, y), -1 to the right.

    Returns:
        True if (x, y) is reached; x and y of the first link's unit vector, then of the second's, in the frame
        of (x, y); and the sine of the turn from the first to the second, anticlockwise positive.
    """
    squared = x * x + y * y
    if squared > (first + second) ** 2 or squared < (first - second) ** 2 or squared == 0.0:
        return False, 1.0, 0.0, 1.0, 0.0, 0.0
    per_distance, per_second = 1.0 / math.sqrt(squared), 1.0 / second
    cos = (squared + first * first - second * second) * per_distance / (2.0 * first)
    sin = side * math.sqrt(max(0.0, 1.0 - cos * cos))
    ahead_x, ahead_y = x * per_distance, y * per_distance
    first_x, first_y = cos * ahead_x - sin * ahead_y, cos * ahead_y + sin * ahead_x
    second_x, second_y = (x - first * first_x) * per_second, (y - first * first_y) * per_second
    return True, first_x, first_y, second_x, second_y, first_x * second_y - first_y * second_x
