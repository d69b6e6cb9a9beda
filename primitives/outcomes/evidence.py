"""Findings of an attempt: facts, and the pictures and scans that decided it."""

from __future__ import annotations

from dataclasses import dataclass, field

from handcart.robotics.numerics.arrays import ByteArray, FloatArray

from .calibrated import Calibrated
from .cause import Cause, cause_of
from .drawn_map import DrawnMap


@dataclass
class Evidence:
    """Evidence (facts, pictures, scans and causes) that a primitive collects during its motion for the run's
    folder.
    """

    facts: dict[str, float | str] = field(default_factory=dict)
    """Figures and texts; names include the unit."""
    pictures: dict[str, ByteArray] = field(default_factory=dict)
    """Pictures by name, grey (h, w) or BGR (h, w, 3), with findings drawn in."""
    points: dict[str, FloatArray] = field(default_factory=dict)
    """(n, 2) on the map in [m]; name to points."""
    decisive: str = ""
    """Name of the picture that decided the outcome; empty for the last one."""
    calibrated: dict[str, Calibrated] = field(default_factory=dict)
    """Proposed changes of the robot's file, by key: `camera.calibrated.focal_px`."""
    maps: dict[str, DrawnMap] = field(default_factory=dict)
    """Maps that were drawn, by name."""
    result: str = ""
    """Measured result, one of the primitive's `results`; empty for the usual one."""
    causes: list[Cause] = field(default_factory=list)
    """Cause that ended the motion, followed by the cause that ended the way back, if that failed too."""

    def blame(self, error: Exception, restoring: bool = False) -> None:
        """Append the cause of an exception to `causes`.

        Args:
            error: the caught exception, with its traceback.
            restoring: True if the exception was raised on the way back to the start, or as the hand withdrew.
        """
        self.causes.append(cause_of(error, restoring))
