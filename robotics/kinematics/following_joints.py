"""Joints that follow others, as a linear map."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from handcart.robotics.numerics.arrays import FloatArray


def following(
    followers: Mapping[str, tuple[str, float, float]],
    names: Sequence[str],
    row: Callable[[str], int],
    count: int,
) -> tuple[FloatArray | None, FloatArray]:
    """Return how the positions (m,) of all joints follow from those of an arm (n,).

    They are factors @ arm + offsets; joints that follow none of the arm's are at 0.
    Pinocchio's own mimic joints can't be nearer to the root than the joint that they follow.

    Args:
        followers: leader, factor and offset by the name of a joint that follows one of the arm's: its
            position is factor times the leader's plus offset, in [rad] or [m].
        names: of the arm's n joints.
        row: returns the number of a joint among all m.
        count: number m of all joints.

    Returns:
        Factors (m, n), None if no joint follows another; and offsets (m,), in [rad] or [m].
    """
    offsets = np.zeros(count)
    if not followers:
        return None, offsets
    factors = np.zeros((count, len(names)))
    for column, name in enumerate(names):
        factors[row(name), column] = 1.0
    for name, (leader, factor, offset) in followers.items():
        factors[row(name), names.index(leader)] = factor
        offsets[row(name)] = offset
    return factors, offsets
