"""How often restoring is tried before a person is called."""

from __future__ import annotations

from typing import NamedTuple


class Patience(NamedTuple):
    """Attempts of restoring, and the rest between them.

    What stops a robot on its way back may pass by itself: a drive that refuses a command, a reading that is
    late, somebody in the way.
    """

    attempts: int = 1
    """How often it is tried, at least once."""
    wait_s: float = 5.0
    """Time at rest before it is tried again, in [s]."""


NO_PATIENCE = Patience()
"""A fault while restoring calls a person at once."""
