"""Opening a file of a run in a window of its own, where no token can be sent along."""

from __future__ import annotations

import secrets
import time
from pathlib import Path
from typing import NamedTuple

VALID_S = 30.0
MAX_TICKETS = 100


class Ticket(NamedTuple):
    """Permission to open one file of a run in the browser, once, without the access token."""

    folder: Path
    name: str
    until: float


class Tickets:
    """Collection of one-time permissions (tickets) to open a file of a run in the browser without the access
    token.
    """

    def __init__(self) -> None:
        """Create an empty collection."""
        self._given: dict[str, Ticket] = {}

    def give(self, folder: Path, name: str) -> str:
        """Return a new random word with which a file can be opened once within `VALID_S` seconds.

        Args:
            folder: folder of the run.
            name: path of the file in that folder.
        """
        while len(self._given) >= MAX_TICKETS:
            del self._given[next(iter(self._given))]
        word = secrets.token_urlsafe(24)
        self._given[word] = Ticket(folder, name, time.monotonic() + VALID_S)
        return word

    def take(self, word: str) -> Ticket | None:
        """Return the ticket (permission to open a file once) that was issued with a random word, and
        invalidate it.

        The result is None if the word is unknown, or was issued more than `VALID_S` seconds ago.
        """
        ticket = self._given.pop(word, None)
        return ticket if ticket is not None and time.monotonic() < ticket.until else None
