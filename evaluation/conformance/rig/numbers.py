"""Readings of sensors as numbers, and broken readings."""

from __future__ import annotations

from typing import Any

import numpy as np

from handcart.robotics.numerics.arrays import FloatArray


def as_numbers(reading: Any, measured: tuple[str, ...] = ()) -> FloatArray | None:
    """Return all measured values of a reading as one array (n,), in its units; None if nothing was measured.

    Args:
        reading: result of a capability.
        measured: fields of a named tuple that count; empty: all.
    """
    if reading is None:
        return None
    if isinstance(reading, tuple):
        parts = (as_numbers(field) for field in _fields(reading, measured).values())
        return np.concatenate([part for part in parts if part is not None])
    return np.array(reading, dtype=np.float64).ravel()


def broken(reading: Any, measured: tuple[str, ...] = ()) -> Any:
    """Return the reading that a sensor would give if it were broken: NaN values, or a black picture."""
    match reading:
        case tuple():
            fields = {name: broken(field) for name, field in _fields(reading, measured).items()}
            return reading._replace(**fields)  # type: ignore[attr-defined]
        case float():
            return np.nan
        case np.ndarray():
            picture = reading.dtype == np.uint8
            return np.zeros_like(reading) if picture else np.full_like(reading, np.nan)
    return reading  # a number that counts, a yes or no, nothing


def _fields(reading: Any, measured: tuple[str, ...]) -> dict[str, Any]:
    return {name: getattr(reading, name) for name in measured or reading._fields}
