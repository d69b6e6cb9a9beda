"""Announcements of effects that cannot be verified after a crash."""

from __future__ import annotations


class Intents:
    """Receiver of announcements of effects that can't be repeated; this base class keeps none.

    A run's journal keeps them, so that after a crash it is known what may have happened.
    """

    def intends(self, effect: str) -> None:
        """Announce an effect that is about to begin, such as the fingers closing on something."""

    def passed(self, what: str) -> None:
        """Announce that a point of no return is passed."""

    @property
    def kept(self) -> bool:
        """True if all announcements so far would outlast a crash."""
        return True


UNRECORDED_INTENTS = Intents()
"""Announcements of attempts without a journal."""
