"""Limits on repeating the restoring before a person is called."""

from __future__ import annotations

from typing import NamedTuple


class Patience(NamedTuple):
    """Number of attempts to bring the robot back to the start, and the time between two attempts.

    A fault on the way back may pass by itself: a drive that refuses a command, a late reading, a person in
    the way.
    """

    attempts: int = 1
    """Maximum number of attempts to restore, at least one."""
    wait_s: float = 5.0
    """Time at rest before restoring is tried again, in [s]."""


NO_PATIENCE = Patience()
"""A fault while restoring calls a person at once."""
