"""A size compared with what is allowed."""

from __future__ import annotations

import math


def at_most(words: str, size: float, measured: float, fixed: float = math.inf) -> list[str]:
    """Return what is wrong with a size, in words; nothing where it is within both limits.

    Args:
        words: with a place for the size.
        size: by ground truth.
        measured: what the claimed uncertainty allows; NaN allows nothing.
        fixed: what is allowed however uncertain the claim is; needed wherever `measured` grows with a claim.
    """
    if size <= measured and size <= fixed:
        return []
    most = measured if math.isnan(measured) else min(measured, fixed)
    return [f"{words.format(size)} (at most {most:.1f})"]
