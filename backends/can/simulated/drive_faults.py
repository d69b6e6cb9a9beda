"""What a simulated drive does wrong."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field


@dataclass
class DriveFaults:
    """Nothing at first; a bench sets what a drive is to do wrong."""

    silent: bool = False
    """It sends no PDOs any more, though it still listens."""
    no_heartbeat: bool = False
    gain: float = 1.0
    """What the motor makes of its demand: 0 stuck, -1 the wrong way, 2 twice as far; it notices nothing."""
    late: int = 0
    """Periods by which the motor is behind its demand."""
    frozen: bool = False
    """It tells the position and velocity that it had."""
    jump: int = 0
    """Added to the position that it tells, in [counts]."""
    jumps_in_turn: bool = False
    """That is told every other time only."""
    wraps: int = 0
    """Counts after which its encoder starts over, in secret: 0 never."""
    drops: float = 0.0
    """Share of its answers that get lost."""
    short: bool = False
    """Its answers are a byte too short."""
    keeps: dict[tuple[int, int], int] = field(default_factory=dict)
    """Objects that stay what they are, whatever is written: index and sub-index to value."""

    _behind: deque[float] = field(default_factory=deque)
    _dropped: float = 0.0
    _astray: float = 0.0

    @property
    def notices(self) -> bool:
        """Whether the drive's own supervision of its motor works."""
        return self.gain == 1.0 and self.late == 0

    def astray(self, way: float) -> float:
        """How far the motor is from its demand, which goes a way in a period, in [counts]."""
        if not self.notices:
            self._behind.append(way * self.gain)
            self._astray += (self._behind.popleft() if len(self._behind) > self.late else 0.0) - way
        return self._astray

    def lost(self) -> bool:
        """Whether the next answer gets lost, evenly spread."""
        self._dropped += self.drops
        if self._dropped < 1.0:
            return False
        self._dropped -= 1.0
        return True
