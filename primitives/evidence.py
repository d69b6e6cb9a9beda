"""What an attempt found: facts, and the pictures and scans that decided it."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray


@dataclass
class Evidence:
    """Collected by a primitive while it runs; written into the run's folder by who runs it."""

    facts: dict[str, float | str] = field(default_factory=dict)
    """In figures and words, names with their unit."""
    pictures: dict[str, NDArray[np.uint8]] = field(default_factory=dict)
    """Grey (h, w) or BGR (h, w, 3), what was found drawn in; name to picture."""
    points: dict[str, NDArray[np.float64]] = field(default_factory=dict)
    """(n, 2) on the map in [m]; name to points."""
