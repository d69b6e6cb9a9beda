"""Error of a path that cannot be tracked."""

from __future__ import annotations

from handcart.robotics.numerics.arrays import FloatArray


class Untrackable(ValueError):
    """A path that no arm, or no set of placements, can follow.

    Attributes:
        index: number of the first bad point, from 0; a file's line follows from it.
        why: what is wrong with that point.
        nearest: position (3,) near that point, in [m], that could be tracked; None where none is known.
    """

    def __init__(self, index: int, why: str, nearest: FloatArray | None = None) -> None:
        self.index = index
        self.why = why
        self.nearest = nearest
        proposal = "" if nearest is None else f"; nearest that can be reached: {_words(nearest)}"
        super().__init__(f"point {index} of the path {why}{proposal}")


def _words(point: FloatArray) -> str:
    return "(" + ", ".join(f"{value:.3f}" for value in point) + ") m"
