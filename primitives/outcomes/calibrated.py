"""Results of a calibration of the robot itself."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple


class Calibrated(NamedTuple):
    """Calibrated value of a parameter of the robot's file, with sigma; the unit ends its key, as in
    `focal_px`.
    """

    value: float | tuple[float, ...]
    sigma: float | tuple[float, ...]
    """Standard deviation of the value; of several values, one for each."""


def as_facts(found: Mapping[str, Calibrated]) -> dict[str, float | str]:
    """Return each calibrated value and its standard deviation as facts for the journal, named by the last
    part of the value's key.

    The key `camera.calibrated.focal_px` gives the facts `focal_px` and `focal_px_sigma`.
    """
    facts: dict[str, float | str] = {}
    for key, (value, sigma) in found.items():
        name = key.rpartition(".")[2]
        facts |= {name: _short(value), f"{name}_sigma": _short(sigma)}
    return facts


def _short(value: float | tuple[float, ...]) -> float | str:
    if isinstance(value, tuple):
        return ", ".join(f"{item:.4g}" for item in value)
    return float(f"{value:.5g}")
