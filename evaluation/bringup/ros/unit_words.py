"""Likely causes of a ratio between two measurements of one motion."""

from __future__ import annotations

import math

UNIT_NAMES = {math.degrees(1.0): "degrees", 1e3: "millimetres", 1e2: "centimetres"}
UNIT_TOLERANCE = 0.4


def unit_hint(read: float, true: float) -> str:
    """Describe how a reading differs from the true value: by its sign, by a wrong unit, or by a factor.

    Args:
        read: the reading, in any unit.
        true: the true value, in the same unit.
    """
    if abs(read) < 1e-6 or abs(true) < 1e-6:
        return "one of both stood still"
    ratio = read / true
    sign = "the sign is the other way round" if ratio < 0.0 else ""
    for factor, unit in UNIT_NAMES.items():
        for size in (factor, 1.0 / factor):
            if abs(abs(ratio) / size - 1.0) < UNIT_TOLERANCE:
                words = f"a factor of {abs(ratio):.3g}: {unit}?"
                return f"{sign}, and {words}" if sign else words
    return sign or f"a factor of {ratio:.3g}"
