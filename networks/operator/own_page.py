"""Access control of a page on this machine: its own requests only, with the token that it was opened with."""

from __future__ import annotations

import hmac
import secrets
from collections.abc import Collection
from typing import NamedTuple

SECURITY_HEADERS = {
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-store",
}
"""Headers of every answer."""
_OWN_SITE = ("same-origin", "none")


class Refusal(NamedTuple):
    """Status and reason of a refused request."""

    status: int
    words: str


class OwnPage:
    """Guard that detects foreign requests before anything is done for them."""

    def __init__(self, hosts: Collection[str]) -> None:
        """Accept only requests to these names of this machine, `NAME:PORT` as browsers send them."""
        self.hosts = frozenset(hosts)
        self.token = secrets.token_urlsafe(24)

    def stranger(self, host: str | None, origin: str | None, site: str | None) -> Refusal | None:
        """Return why a request is not the page's own, by Host, Origin and Sec-Fetch-Site (rows U2, U3).

        None if it may be the page's own; its token is still to be checked.
        """
        if host not in self.hosts:
            return Refusal(421, "another host's name: this page is reached by the address that was printed")
        if origin is not None and origin not in {f"http://{item}" for item in self.hosts}:
            return Refusal(403, "another site asks for this")
        if site is not None and site not in _OWN_SITE:
            return Refusal(403, "another site asks for this")
        return None

    def knows(self, token: str) -> bool:
        """Return whether a token is right, in a time that does not depend on where it differs (row U5)."""
        # Bytes that are not text are kept as they are.
        return hmac.compare_digest(token.encode(errors="surrogateescape"), self.token.encode())
