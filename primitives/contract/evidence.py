"""What an attempt found: facts, and the pictures and scans that decided it."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from .calibrated import Calibrated
from .cause import Cause, cause_of


@dataclass
class Evidence:
    """Collected by a primitive while it runs; written into the run's folder by who runs it."""

    facts: dict[str, float | str] = field(default_factory=dict)
    """In figures and words, names with their unit."""
    pictures: dict[str, NDArray[np.uint8]] = field(default_factory=dict)
    """Grey (h, w) or BGR (h, w, 3), what was found drawn in; name to picture."""
    points: dict[str, NDArray[np.float64]] = field(default_factory=dict)
    """(n, 2) on the map in [m]; name to points."""
    decisive: str = ""
    """Which picture decided how the attempt ended; empty for the last one."""
    calibrated: dict[str, Calibrated] = field(default_factory=dict)
    """What of the robot's file should change, by key: `camera.calibrated.focal_px`."""
    causes: list[Cause] = field(default_factory=list)
    """What ended the motion; behind it what ended the way back, where that failed too."""
    limits: dict[str, float] = field(default_factory=dict)
    """What was allowed of each residual that was measured."""

    def blame(self, error: Exception, restoring: bool = False) -> None:
        """Note what an exception that left the primitive says of why."""
        self.causes.append(cause_of(error, restoring))
