"""Comparison of a measured size with its limit."""

from __future__ import annotations


def exceeds(size: float, most: float) -> bool:
    """Return whether a measured size is above a limit, or no number.

    A reading of NaN is not above any limit, so that `size > most` would pass it as good.
    """
    return not size <= most
