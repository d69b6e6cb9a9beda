"""Who may ask the console for anything: the page that it served itself, with the token that it was given."""

from __future__ import annotations

import hmac
import secrets
from collections.abc import Awaitable, Callable, Collection

from aiohttp import hdrs, web

Handler = Callable[[web.Request], Awaitable[web.StreamResponse]]

POLICY = (
    "default-src 'self'; img-src 'self' blob:; object-src 'none'; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'none'"
)
HEADERS = {
    "Content-Security-Policy": POLICY,
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-store",
}
OPEN = ("/", "/console.js", "/console.css", "/favicon.ico")
"""What holds no secret: the page itself, which asks for the token."""
TICKETS = "/ticket/"
"""Below it are files that a ticket opens once, instead of the token."""
_OWN_SITE = ("same-origin", "none")


class Guard:
    """Refuses before anything is done, with a status and a reason in words."""

    def __init__(self, hosts: Collection[str]) -> None:
        """Let those names of this machine pass, with their ports, as browsers send them."""
        self.hosts = frozenset(hosts)
        self.token = secrets.token_urlsafe(24)

    @web.middleware
    async def check(self, request: web.Request, handler: Handler) -> web.StreamResponse:
        """The middleware."""
        refused = self._refused(request)
        if refused is not None:
            return refused
        try:
            answer = await handler(request)
        except web.HTTPException as error:
            answer = said(error.status, error.reason)
        except web.RequestPayloadError:
            answer = said(400, "what was sent isn't packed as it says")
        except Exception as error:  # the page tells it to who asked
            answer = said(500, f"a fault in handcart: {type(error).__name__}: {error}")
        if not answer.prepared:
            for name, value in HEADERS.items():
                answer.headers.setdefault(name, value)
        return answer

    def _refused(self, request: web.Request) -> web.Response | None:
        if request.headers.get(hdrs.HOST, "") not in self.hosts:
            return said(421, "another host's name: this page is reached by the address that was printed")
        origin = request.headers.get(hdrs.ORIGIN)
        if origin is not None and origin not in {f"http://{host}" for host in self.hosts}:
            return said(403, "another site asks for this")
        if request.headers.get("Sec-Fetch-Site", "none") not in _OWN_SITE:
            return said(403, "another site asks for this")
        if request.headers.get(hdrs.UPGRADE):
            return said(403, "there are no sockets here")
        if request.path in OPEN or request.path.startswith(TICKETS):
            return None if request.method == "GET" else said(405, "only GET")
        if not self._known(request.headers.get(hdrs.AUTHORIZATION, "")):
            return said(401, "the token is missing or wrong; it is in the address that was printed")
        if request.method not in ("GET", "POST"):
            return said(405, "only GET and POST")
        if request.method == "POST" and request.content_type != "application/json":
            return said(403, "commands are JSON")
        return None

    def _known(self, authorization: str) -> bool:
        kind, _, token = authorization.partition(" ")
        return kind == "Bearer" and hmac.compare_digest(
            # Bytes that are no text come as they are.
            token.encode(errors="surrogateescape"),
            self.token.encode(),
        )


def said(status: int, words: str) -> web.Response:
    """An answer in words."""
    body = {"ok": status < 400, "error": words}
    return web.json_response(body, status=status, headers=HEADERS)
