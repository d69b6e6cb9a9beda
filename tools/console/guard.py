"""Access control of the console: only the page that it served itself, with the token that it was given."""

from __future__ import annotations

from collections.abc import Awaitable, Callable

from aiohttp import hdrs, web

from handcart.networks.operator import own_page
from handcart.networks.operator.own_page import OwnPage

Handler = Callable[[web.Request], Awaitable[web.StreamResponse]]

PAGE_POLICY = (
    "default-src 'self'; img-src 'self' blob:; object-src 'none'; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'none'"
)
PAGE_HEADERS = {"Content-Security-Policy": PAGE_POLICY, **own_page.SECURITY_HEADERS}
OPEN_PATHS = ("/", "/console.js", "/console.css", "/favicon.ico")
"""Paths without secrets: the page itself, which asks for the token."""
TICKETS_PATH = "/ticket/"
"""Path below which a ticket opens a file once, instead of the token."""


class Guard(OwnPage):
    """Middleware of the server that refuses unauthorized requests, with a status and a reason, before they
    are handled.
    """

    @web.middleware
    async def check(self, request: web.Request, handler: Handler) -> web.StreamResponse:
        """Pass an authorized request on to its handler, and answer any other one with a refusal."""
        refused = self._refused(request)
        if refused is not None:
            return refused
        try:
            answer = await handler(request)
        except web.HTTPException as error:
            answer = said(error.status, error.reason)
        except web.RequestPayloadError:
            answer = said(400, "the request isn't encoded as its headers say")
        except Exception as error:  # the page reports it to the client
            answer = said(500, f"a fault in handcart: {type(error).__name__}: {error}")
        if not answer.prepared:
            for name, value in PAGE_HEADERS.items():
                answer.headers.setdefault(name, value)
        return answer

    def _refused(self, request: web.Request) -> web.Response | None:
        sent = request.headers
        refused = self.stranger(sent.get(hdrs.HOST), sent.get(hdrs.ORIGIN), sent.get("Sec-Fetch-Site"))
        if refused is not None:
            return said(*refused)
        if request.headers.get(hdrs.UPGRADE):
            return said(403, "sockets are not supported here")
        if request.path in OPEN_PATHS or request.path.startswith(TICKETS_PATH):
            return None if request.method == "GET" else said(405, "only GET")
        if not self.has_token(request):
            return said(401, "the token is missing or wrong; it is in the address that was printed")
        if request.method not in ("GET", "POST"):
            return said(405, "only GET and POST")
        if request.method == "POST" and request.content_type != "application/json":
            return said(403, "commands are JSON")
        return None

    def has_token(self, request: web.Request) -> bool:
        """Return whether a request contains the console's access token."""
        kind, _, token = request.headers.get(hdrs.AUTHORIZATION, "").partition(" ")
        return kind == "Bearer" and self.knows(token)


def said(status: int, words: str) -> web.Response:
    """Return a JSON response with a text in the field `error`.

    Args:
        status: HTTP status.
        words: the text, for people.
    """
    body = {"ok": status < 400, "error": words}
    return web.json_response(body, status=status, headers=PAGE_HEADERS)
