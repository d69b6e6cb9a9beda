"""Access control of the page in the browser; viser itself answers every client."""

from __future__ import annotations

import logging
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from importlib.resources import files
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

from handcart.networks.operator.accepting import accept_no_more
from handcart.networks.operator.own_page import SECURITY_HEADERS, OwnPage

if TYPE_CHECKING:
    from websockets.asyncio.server import ServerConnection, serve
    from websockets.http11 import Request, Response

Answer = Callable[["ServerConnection", "Request"], "Response | None"]
TOKEN_PREFIX = "token."
"""Prefix of the token in the subprotocol, the only header of a WebSocket that a script can set."""
TOKEN_MISSING_TEXT = "the token is missing or wrong; it is in the address that was printed"


class Gate(OwnPage):
    """Guard of a viser server, whose WebSockets need the page's own origin and the token in its address."""

    def __init__(self, host: str) -> None:
        """Create a guard for `host`, given with its port; it guards nothing before a server is made."""
        super().__init__([host])
        self.guards = False
        self.policy = (
            "default-src 'self' data: blob: 'unsafe-inline' 'unsafe-eval'; "
            f"connect-src 'self' ws://{host} data: blob:; "
            "object-src 'none'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
        )
        """Content security policy: viser's page is one file with all its scripts, and may reach no other
        host.
        """

    @contextmanager
    def before_servers(self) -> Iterator[None]:
        """Guard the servers that viser starts in this context.

        viser has no option for guarding its server, so the module `websockets` is replaced inside viser only;
        other servers of this process are unchanged. A reverse proxy would not help, because viser would still
        answer every client on its own port.
        """
        import viser.infra
        import websockets
        from websockets.asyncio import server

        def guarded(*args: Any, process_request: Answer, **options: Any) -> Any:
            self.guards = True
            answer = partial(self.answer, process_request)
            return _drained(server.serve)(*args, process_request=answer, logger=_unheard(), **options)

        inner: Any = sys.modules[viser.infra.WebsockServer.__module__]
        nearest = _with(websockets.asyncio, server=_with(server, serve=guarded))
        inner.websockets = _with(websockets, asyncio=nearest)
        try:
            yield
        finally:
            inner.websockets = websockets

    def answer(self, behind: Answer, connection: ServerConnection, request: Request) -> Response | None:
        """Return the HTTP response to a request: a refusal or viser's page; None to open a WebSocket.

        Args:
            behind: function that returns the guarded server's own response to a request.
            connection: connection of the client.
            request: the client's request.
        """
        sent = request.headers

        def one(name: str) -> str | None:
            return ", ".join(sent.get_all(name)) if name in sent else None

        # The page itself contains no secret, and the console, another site, links to it.
        site = one("Sec-Fetch-Site") if "Upgrade" in sent else None
        refused = self.stranger(one("Host"), one("Origin"), site)
        if refused is not None:
            return connection.respond(*refused)
        if "Upgrade" in sent:
            if "Origin" not in sent:  # browsers always send it
                return connection.respond(403, "another program asks for this")
            if not self._has_token(one("Sec-WebSocket-Protocol") or ""):
                return connection.respond(401, TOKEN_MISSING_TEXT)
            return behind(connection, request)
        if "Accept-Encoding" in sent:  # compression saves no time on one machine
            del sent["Accept-Encoding"]
        page = behind(connection, request)
        return None if page is None else self._dressed(page)

    def _has_token(self, protocols: str) -> bool:
        given = [part.strip() for part in protocols.split(",")]
        return any(
            item.startswith(TOKEN_PREFIX) and self.knows(item.removeprefix(TOKEN_PREFIX)) for item in given
        )

    def _dressed(self, page: Response) -> Response:
        """Return the page with our script before all others, and with the headers that restrict it."""
        script = files(__package__).joinpath("before_viser.js").read_bytes()
        page.body = page.body.replace(b"<head>", b"<head><script>" + script + b"</script>", 1)
        del page.headers["Content-Length"]
        for name, value in {
            **SECURITY_HEADERS,
            "Content-Security-Policy": self.policy,
            "Content-Length": str(len(page.body)),
        }.items():
            page.headers[name] = value
        return page


def _with(module: object, **changed: object) -> SimpleNamespace:
    """Return the names of a module, some of them changed."""
    return SimpleNamespace(**{**vars(module), **changed})


def _drained(serve: type[serve]) -> type[serve]:
    """Return a server class that closes all WebSockets on exit, including those that connect meanwhile.

    The class of websockets waits ten seconds for silent connections.
    """
    from websockets.protocol import State

    class Drained(serve):  # type: ignore[misc, valid-type]
        async def __aexit__(self, *error: Any) -> None:
            await accept_no_more(self.server.sockets)
            for connection in list(self.server.handlers):
                if connection.protocol.state is State.CONNECTING:
                    connection.transport.abort()
            await super().__aexit__(*error)

    return Drained


def _unheard() -> logging.Logger:
    """Return a logger that discards messages about malformed requests and about headers, which hold the
    token.
    """
    logger = logging.getLogger(__name__)
    logger.addHandler(logging.NullHandler())
    logger.propagate = False
    logger.setLevel(logging.CRITICAL)
    return logger
