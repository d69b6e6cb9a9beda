"""Announcements of effects that cannot be verified after a crash."""

from __future__ import annotations


class Intents:
    """Receiver of the announcements by which a primitive reports effects that can't be repeated.

    An example is the closing of the fingers. This base class ignores the announcements. In a run, a subclass
    writes them to the journal, so that after a crash it is known which effects may have happened.
    """

    def intends(self, effect: str) -> None:
        """Announce an effect that is about to begin, such as the fingers closing on something."""

    def passed(self, what: str) -> None:
        """Announce that the running action cannot be undone any more; `what` names the step for the
        journal.
        """

    @property
    def kept(self) -> bool:
        """True if all effects announced so far are stored, so that a crash does not lose them."""
        return True


UNRECORDED_INTENTS = Intents()
"""Announcements of attempts without a journal."""
