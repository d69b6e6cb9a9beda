"""Commands of joints that take effect later than they arrive."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping


class LateCommands:
    """Delay of commanded joint positions by a number of periods, which simulates slow controllers."""

    def __init__(self, periods: int) -> None:
        """Delay positions by a number of periods; 0 for no delay."""
        self._periods = periods
        self._kept: deque[Mapping[str, float]] = deque(maxlen=periods + 1)

    def passed(self, wanted: Mapping[str, float]) -> Mapping[str, float]:
        """Return the joint positions that take effect now, which were received a fixed number of periods ago.

        The result is empty until the first received positions take effect.

        Args:
            wanted: positions received last, in [rad] or [m] by the joint's name.
        """
        if not self._periods:
            return wanted
        self._kept.append(dict(wanted))
        return self._kept[0] if len(self._kept) > self._periods else {}
