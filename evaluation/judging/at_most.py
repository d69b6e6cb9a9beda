"""Comparison of a size with its limits."""

from __future__ import annotations

import math


def at_most(words: str, size: float, measured: float, fixed: float = math.inf) -> list[str]:
    """Compare the size of an error or motion with two limits; return a message if it exceeds one of them.

    Args:
        words: message with a format field for the size.
        size: true size, by ground truth.
        measured: limit derived from the uncertainty that the robot claims; NaN allows nothing.
        fixed: limit that does not depend on the robot; needed wherever a robot could claim a large
            uncertainty.

    Returns:
        The message with the smaller limit, as the only element; empty if `size` is within both limits.
    """
    if size <= measured and size <= fixed:
        return []
    most = measured if math.isnan(measured) else min(measured, fixed)
    return [f"{words.format(size)} (at most {most:.1f})"]
