"""Error of a path that cannot be tracked."""

from __future__ import annotations

from handcart.robotics.numerics.arrays import FloatArray


class Untrackable(ValueError):
    """Error for a path that the arm cannot follow, or for which no set of base poses exists.

    Attributes:
        index: number of the path's first point that cannot be tracked, from 0; a caller can find its line in
            a file.
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
