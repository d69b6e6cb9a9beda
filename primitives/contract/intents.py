"""Announcements of effects that cannot be verified after a crash."""

from __future__ import annotations


class Intents:
    """Hears of effects that can't simply be done once more; this one keeps nothing.

    A run's journal keeps them, so that after a crash it is known what may have happened.
    """

    def intends(self, effect: str) -> None:
        """Announce an effect that is about to begin, such as the fingers closing on something."""

    def passed(self, what: str) -> None:
        """Announce that a point of no return is passed."""

    @property
    def kept(self) -> bool:
        """True once all announcements would outlast a crash."""
        return True


UNRECORDED_INTENTS = Intents()
"""Announcements of attempts without a journal."""
