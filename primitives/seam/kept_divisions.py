"""Divisions of seams that were found before: the trials of a campaign ask for the same again."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterable

from handcart.robotics.manipulation.placement.placements import Placements

MAX_DIVISIONS = 32  # that are kept


class KeptDivisions:
    """Cache of divisions of a seam into parts, each tracked from one pose of the base.

    The key of a division is all data on which it depends.
    """

    def __init__(self) -> None:
        self._kept: dict[bytes, Placements] = {}

    def division(self, follows_from: Iterable[bytes], find: Callable[[], Placements]) -> Placements:
        """Return the division of a seam among base poses that was kept for the same data; otherwise find and
        keep it.

        Args:
            follows_from: all data on which the division depends; equal data has an equal division.
            find: returns the division if none is kept; it may raise.
        """
        whole = hashlib.sha256()
        for chunk in follows_from:
            whole.update(len(chunk).to_bytes(8, "little") + chunk)
        key = whole.digest()
        if key not in self._kept:
            found = find()
            if len(self._kept) >= MAX_DIVISIONS:
                del self._kept[next(iter(self._kept))]
            self._kept[key] = found
        return self._kept[key]
