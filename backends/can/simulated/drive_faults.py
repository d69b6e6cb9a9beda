"""Faults of a simulated drive."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field


@dataclass
class DriveFaults:
    """Faults of a simulated drive, none at first; a bench sets them. The unit [counts] is a step of the
    drive's encoder.
    """

    silent: bool = False
    """True if the drive sends no PDOs any more, though it still receives frames."""
    no_heartbeat: bool = False
    gain: float = 1.0
    """Ratio of the motor's motion to its demand: 0 stuck, -1 reversed, 2 twice as far; the drive does not
    notice.
    """
    late: int = 0
    """Periods by which the motor is behind its demand."""
    frozen: bool = False
    """True if the drive keeps reporting an old position and velocity."""
    jump: int = 0
    """Offset of the reported position [counts]."""
    jumps_in_turn: bool = False
    """True if the offset is applied every second time only."""
    wraps: int = 0
    """Counts after which the drive's encoder starts over although its EDS does not say so; 0: never."""
    drops: float = 0.0
    """Share of the drive's answers that get lost, 0 to 1."""
    short: bool = False
    """True if the drive's answers are a byte too short."""
    keeps: dict[tuple[int, int], int] = field(default_factory=dict)
    """Values that objects keep whatever is written to them, by index and sub-index."""

    _behind: deque[float] = field(default_factory=deque)
    _dropped: float = 0.0
    _astray: float = 0.0

    @property
    def notices(self) -> bool:
        """True if the drive detects following errors; with an injected wrong gain (`gain`) or delay (`late`)
        of its motion it does not.
        """
        return self.gain == 1.0 and self.late == 0

    def astray(self, way: float) -> float:
        """Update and return the position error that the faults cause: motor minus set-point, in [counts].

        Args:
            way: motion of the set-point in this period, in [counts].
        """
        if not self.notices:
            self._behind.append(way * self.gain)
            self._astray += (self._behind.popleft() if len(self._behind) > self.late else 0.0) - way
        return self._astray

    def lost(self) -> bool:
        """Return True if the drive's next answer is to be lost; called once for each answer.

        The lost answers are evenly spread over all answers.
        """
        self._dropped += self.drops
        if self._dropped < 1.0:
            return False
        self._dropped -= 1.0
        return True
