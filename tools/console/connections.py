"""Limits on the number of connections, and on their silence (row U11)."""

from __future__ import annotations

import asyncio
from collections.abc import Callable

from aiohttp import web

from .guard import Handler

MOST_KNOWN = 200
"""Maximum number of connections that have shown the token."""
MOST_UNKNOWN = 512
"""Maximum number of other connections. It is many times the number accepted in one round of the loop
(`ACCEPTED_AT_ONCE` on each of two addresses): a request that comes with its connection is read a few rounds
later, long before that connection could be the oldest of them."""
ACCEPTED_AT_ONCE = 16
WAITING_TO_BE_ACCEPTED = 4096
"""Length of the kernel's queue: a client that finds it full is served only a second later."""
SILENT_S = 10.0
"""Time within which a new connection has to send a complete request head, in [s]."""


class Connections:
    """Factory of a web server's connections that always has room for clients with the access token.

    A connection is unknown until it sends a request with the token. Any process of this machine can open
    hundreds of unknown connections, but a STOP has to arrive nevertheless. If there are too many connections,
    the oldest unknown connection is therefore closed, and never a new one.
    """

    def __init__(self, has_token: Callable[[web.Request], bool]) -> None:
        """Prepare without a server; `has_token` returns whether a request contains the token."""
        self._has_token = has_token
        self.of: web.Server | None = None
        """The application's server; None: it is not set up."""
        self._silent: set[asyncio.BaseProtocol] = set()
        self._known: set[asyncio.BaseProtocol] = set()

    def __call__(self) -> asyncio.BaseProtocol:
        """Return a new connection, for `loop.create_server`."""
        assert self.of is not None
        protocol: asyncio.BaseProtocol = self.of()
        loop = asyncio.get_running_loop()
        self._silent.add(protocol)
        loop.call_later(SILENT_S, self._look, protocol)
        # It is connected in the loop's next round: before that it can neither be counted nor closed.
        loop.call_soon(loop.call_soon, self._count)
        return protocol

    @web.middleware
    async def heard(self, request: web.Request, handler: Handler) -> web.StreamResponse:
        """Record that a connection has sent a request, and whether the request has the access token; then
        pass the request on.
        """
        self._silent.discard(request.protocol)
        if self._has_token(request) and len(self._known) < MOST_KNOWN:
            self._known.add(request.protocol)
        return await handler(request)

    def _count(self) -> None:
        assert self.of is not None
        opened = [connection for connection in self.of.connections if _is_open(connection)]
        self._known &= set(opened)
        unknown = [item for item in opened if item not in self._known]
        for item in unknown[: len(unknown) - MOST_UNKNOWN] if len(unknown) > MOST_UNKNOWN else []:
            _close(item)

    def _look(self, protocol: asyncio.BaseProtocol) -> None:
        if protocol in self._silent:
            self._silent.discard(protocol)
            _close(protocol)


def _is_open(protocol: asyncio.BaseProtocol) -> bool:
    transport = getattr(protocol, "transport", None)
    return transport is not None and not transport.is_closing()


def _close(protocol: asyncio.BaseProtocol) -> None:
    transport = getattr(protocol, "transport", None)
    if transport is not None:
        transport.abort()
