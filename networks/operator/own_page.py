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
    """HTTP status and reason of a refused request."""

    status: int
    words: str


class OwnPage:
    """Guard of a web page's server that detects requests of other sites, and of clients without the token."""

    def __init__(self, hosts: Collection[str]) -> None:
        """Accept only requests to these names of this machine, `NAME:PORT` as browsers send them."""
        self.hosts = frozenset(hosts)
        self.token = secrets.token_urlsafe(24)

    def stranger(self, host: str | None, origin: str | None, site: str | None) -> Refusal | None:
        """Return the refusal of a request whose headers show that it comes from another site.

        The result is None if they do not. The request's token still has to be checked with `knows` (rows U2
        and U3 of faults.md).

        Args:
            host: header Host; None if it is missing.
            origin: header Origin; None if it is missing.
            site: header Sec-Fetch-Site; None if it is missing.
        """
        if host not in self.hosts:
            return Refusal(421, "another host's name: this page is reached by the address that was printed")
        if origin is not None and origin not in {f"http://{item}" for item in self.hosts}:
            return Refusal(403, "another site asks for this")
        if site is not None and site not in _OWN_SITE:
            return Refusal(403, "another site asks for this")
        return None

    def knows(self, token: str) -> bool:
        """Return whether a token is the access token of this server.

        The comparison takes the same time wherever the tokens differ (row U5 of faults.md).
        """
        # Bytes that are not text are kept as they are.
        return hmac.compare_digest(token.encode(errors="surrogateescape"), self.token.encode())
