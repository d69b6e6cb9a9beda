"""Radius up to which a lens model holds: beyond it its polynomial folds back."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Literal

import numpy as np
from numpy.polynomial import Polynomial

from handcart.robotics.numerics.arrays import FloatArray

LensKind = Literal["brown", "fisheye"]
"""`brown`: Brown's polynomial or the rational one (ROS `plumb_bob`, `rational_polynomial`).

`fisheye`: that of Kannala and Brandt (ROS `equidistant`).
"""


def fold_radius(distortion: FloatArray, lens: LensKind) -> float:
    """Return the distance from the optical axis, of a ray (x/z, y/z), up to which a lens model is valid.

    Up to this distance, rays farther from the axis are farther from it in the picture too; beyond it, the
    model folds back. The distance has no unit, and is infinite if the model never folds back. Only the radial
    terms are considered.

    Args:
        distortion: coefficients without unit, (4,), (5,) or (8,) for `brown`: k1, k2, p1, p2, k3, k4, k5, k6;
            (4,) for `fisheye`.
        lens: kind of the model.
    """
    return _fold_radius(np.ascontiguousarray(distortion, dtype=np.float64).tobytes(), lens)


@lru_cache(maxsize=16)
def _fold_radius(distortion: bytes, lens: LensKind) -> float:
    terms = np.frombuffer(distortion)
    if lens == "fisheye":
        # d/dθ of θ (1 + k1 θ² + k2 θ⁴ + k3 θ⁶ + k4 θ⁸), in s = θ²
        slope = Polynomial([1.0, *(np.arange(3, 3 + 2 * len(terms), 2) * terms)])
        angle = math.sqrt(_first_root(slope))
        return math.tan(angle) if angle < math.pi / 2 else math.inf
    k = np.zeros(8)
    k[: len(terms[:8])] = terms[:8]
    above, below = Polynomial([1.0, k[0], k[1], k[4]]), Polynomial([1.0, k[5], k[6], k[7]])
    s = Polynomial([0.0, 1.0])
    # d/dr of r above(r²) / below(r²), times below²: in s = r²
    slope = above * below + 2.0 * s * (above.deriv() * below - above * below.deriv())
    return math.sqrt(min(_first_root(slope), _first_root(below)))


def _first_root(polynomial: Polynomial) -> float:
    """Return the smallest positive root; infinity without one."""
    trimmed = polynomial.trim()
    roots = np.asarray(trimmed.roots() if trimmed.degree() else [], dtype=complex)
    positive = roots.real[(np.abs(roots.imag) < 1e-9) & (roots.real > 0.0)]
    return float(positive.min()) if len(positive) else math.inf
