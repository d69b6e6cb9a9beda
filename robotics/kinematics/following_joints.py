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
    """Return the linear map from the positions (n,) of an arm's joints to the positions (m,) of all joints.

    The positions of all joints are factors @ arm + offsets. Joints that neither belong to the arm nor mimic
    one of its joints are at 0. Pinocchio's own mimic joints are not used: they can't be nearer to the root
    than the joint that they mimic.

    Args:
        followers: leader, factor and offset by the name of a joint that mimics a joint of the arm: its
            position is factor times the leader's plus offset, in [rad] or [m].
        names: names of the arm's n joints.
        row: returns the number of a joint among all m.
        count: number m of all joints.

    Returns:
        Factors (m, n), None if no joint mimics another; and offsets (m,), in [rad] or [m].
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
