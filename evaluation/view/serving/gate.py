"""Who may see a run in the browser: viser itself answers whoever asks."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from importlib.resources import files
from typing import TYPE_CHECKING, Any

from handcart.networks.operator.accepting import accept_no_more
from handcart.networks.operator.own_page import HEADERS, OwnPage

if TYPE_CHECKING:
    from websockets.asyncio.server import ServerConnection, serve
    from websockets.http11 import Request, Response

Answer = Callable[["ServerConnection", "Request"], "Response | None"]
WITH = "token."
"""Before the token, which comes as a subprotocol: no other header of a socket is a script's to set."""
MISSING = "the token is missing or wrong; it is in the address that was printed"


class Gate(OwnPage):
    """Stands before a server of viser's: sockets need the page's own origin and the token."""

    def __init__(self, host: str) -> None:
        """`host` with its port; until a server is made behind it, nothing is guarded."""
        super().__init__([host])
        self.guards = False
        self.policy = (
            "default-src 'self' data: blob: 'unsafe-inline' 'unsafe-eval'; "
            f"connect-src 'self' ws://{host} data: blob:; "
            "object-src 'none'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
        )
        """viser's page is one file with all scripts in it; what it may not is reach anything else."""

    @contextmanager
    def before_servers(self) -> Iterator[None]:
        """Servers that are made meanwhile are guarded; viser hands no such option on to its server."""
        from websockets.asyncio import server

        real = server.serve

        def guarded(*args: Any, process_request: Answer, **options: Any) -> Any:
            self.guards = True
            answer = partial(self.answer, process_request)
            return _drained(real)(*args, process_request=answer, logger=_unheard(), **options)

        server.serve = guarded  # type: ignore[misc, assignment]
        try:
            yield
        finally:
            server.serve = real  # type: ignore[misc]

    def answer(self, behind: Answer, connection: ServerConnection, request: Request) -> Response | None:
        """A refusal, or what the server `behind` answers; None: a socket is opened."""
        sent = request.headers

        def one(name: str) -> str | None:
            return ", ".join(sent.get_all(name)) if name in sent else None

        # The page itself holds no secret, and the console, which is another site, leads to it.
        site = one("Sec-Fetch-Site") if "Upgrade" in sent else None
        refused = self.stranger(one("Host"), one("Origin"), site)
        if refused is not None:
            return connection.respond(*refused)
        if "Upgrade" in sent:
            if "Origin" not in sent:  # browsers tell it always
                return connection.respond(403, "another program asks for this")
            if not self._has_token(one("Sec-WebSocket-Protocol") or ""):
                return connection.respond(401, MISSING)
            return behind(connection, request)
        if "Accept-Encoding" in sent:  # nothing gets faster by it on one machine
            del sent["Accept-Encoding"]
        page = behind(connection, request)
        return None if page is None else self._dressed(page)

    def _has_token(self, protocols: str) -> bool:
        given = [each.strip() for each in protocols.split(",")]
        return any(each.startswith(WITH) and self.knows(each.removeprefix(WITH)) for each in given)

    def _dressed(self, page: Response) -> Response:
        """With our script before all others, and the headers that bind it."""
        script = files(__package__).joinpath("before_viser.js").read_bytes()
        page.body = page.body.replace(b"<head>", b"<head><script>" + script + b"</script>", 1)
        del page.headers["Content-Length"]
        for name, value in {
            **HEADERS,
            "Content-Security-Policy": self.policy,
            "Content-Length": str(len(page.body)),
        }.items():
            page.headers[name] = value
        return page


def _drained(serve: type[serve]) -> type[serve]:
    """The same server; it leaves no socket open, also none that comes while it ends.

    websockets itself waits ten seconds for connections that say nothing.
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
    """Takes what is said of requests that are none, and of headers, in which the token is."""
    logger = logging.getLogger(__name__)
    logger.addHandler(logging.NullHandler())
    logger.propagate = False
    logger.setLevel(logging.CRITICAL)
    return logger
