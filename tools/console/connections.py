"""How many connections there may be, and how long one may say nothing (row U11)."""

from __future__ import annotations

import asyncio

from aiohttp import web

from .guard import Handler

MOST = 200
SILENT_S = 10.0
"""[s] in which a new connection has to have sent a whole request's head."""


class Connections:
    """Makes each new connection; one too many, or one that doesn't come to the point, is closed."""

    def __init__(self) -> None:
        """None yet."""
        self.of: web.Server | None = None
        """The application's server; None: it isn't set up."""
        self._new: set[asyncio.BaseProtocol] = set()

    def __call__(self) -> asyncio.BaseProtocol:
        """For `loop.create_server`."""
        assert self.of is not None
        protocol: asyncio.BaseProtocol = self.of()
        loop = asyncio.get_running_loop()
        self._new.add(protocol)
        loop.call_later(SILENT_S, self._look, protocol)
        # It is connected in the loop's next round: before that it can neither be counted nor closed.
        loop.call_soon(loop.call_soon, self._count, protocol)
        return protocol

    @web.middleware
    async def heard(self, request: web.Request, handler: Handler) -> web.StreamResponse:
        """Note that a connection has sent a request."""
        self._new.discard(request.protocol)
        return await handler(request)

    def _count(self, protocol: asyncio.BaseProtocol) -> None:
        assert self.of is not None
        if len(self.of.connections) > MOST:
            _close(protocol)

    def _look(self, protocol: asyncio.BaseProtocol) -> None:
        if protocol in self._new:
            self._new.discard(protocol)
            _close(protocol)


def _close(protocol: asyncio.BaseProtocol) -> None:
    transport = getattr(protocol, "transport", None)
    if transport is not None:
        transport.abort()
