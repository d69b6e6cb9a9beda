"""How far from where it is the robot believed to be, by ground truth."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from handcart.backends.robot import Robot


@dataclass
class LocalisationSurvey:
    """Looks at a scene once a period."""

    scene: Any
    """Ground truth."""
    periods: int = 0
    squares: float = 0.0
    """Sum of squared distances, in [m²]."""
    farthest: float = 0.0
    """In [m]."""
    turned: float = 0.0
    """The largest error of the heading, in [rad]."""

    def look(self, robot: Robot) -> None:
        """A period has passed."""
        pose, truth = robot.pose, self.scene.base
        off = pose.distance(truth)
        self.periods += 1
        self.squares += off * off
        self.farthest = max(self.farthest, off)
        self.turned = max(self.turned, pose.turn(truth))

    def notes(self) -> tuple[int, float, float, float]:
        """All of it, as it can be noted."""
        return self.periods, self.squares, self.farthest, self.turned

    def go_on(self, notes: tuple[int, float, float, float]) -> None:
        """Take up the notes of the run that this one goes on with."""
        self.periods, self.squares, self.farthest, self.turned = notes

    def figures(self) -> dict[str, float]:
        """For a run's metrics."""
        if not self.periods:
            return {}
        return {
            "localisation_mm_rms": round(1e3 * math.sqrt(self.squares / self.periods), 2),
            "localisation_mm_max": round(1e3 * self.farthest, 2),
            "localisation_deg_max": round(math.degrees(self.turned), 3),
        }
