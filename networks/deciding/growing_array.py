"""Array that grows at its end."""

from __future__ import annotations

from typing import Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

Scalar = TypeVar("Scalar", bound=np.generic)
FIRST_CAPACITY = 256


class GrowingArray(Generic[Scalar]):
    """NumPy array to which rows can be appended; its buffer is doubled when it is full."""

    def __init__(self, first: NDArray[Scalar]) -> None:
        """Begin with some rows (n, ...); later rows have the same shape and type."""
        self._size = len(first)
        self._buffer = np.empty((max(FIRST_CAPACITY, 2 * len(first)), *first.shape[1:]), first.dtype)
        self._buffer[: self._size] = first

    @property
    def all(self) -> NDArray[Scalar]:
        """Array (n, ...) of all rows appended so far, as a view that is valid until the next call of
        `extend`.
        """
        return self._buffer[: self._size]

    def extend(self, rows: NDArray[Scalar]) -> None:
        """Append rows (m, ...) at the end of the array."""
        end = self._size + len(rows)
        if end > len(self._buffer):
            larger = np.empty((2 * end, *self._buffer.shape[1:]), self._buffer.dtype)
            larger[: self._size] = self.all
            self._buffer = larger
        self._buffer[self._size : end] = rows
        self._size = end
