"""The console's server."""

from __future__ import annotations

import asyncio
import logging
import socket
from collections.abc import Callable, Sequence
from contextlib import suppress
from importlib.resources import files
from pathlib import Path

from aiohttp import web

from handcart.files.errors import InputError
from handcart.networks.operator.accepting import accept_no_more

from .connections import ACCEPTED_AT_ONCE, WAITING_TO_BE_ACCEPTED, Connections
from .guard import Guard, Handler
from .handlers import MOST_BODY, Handlers
from .watcher import Watcher

LOOPBACK_ADDRESSES = ("127.0.0.1", "::1")
_EVERY = ("", "0.0.0.0", "::")
PORT, TRIES = 8090, 100
KEPT_S = 15.0
"""Time for which a connection without further requests is kept, in [s]."""
_LOOKS_S = 0.1  # between two looks whether it is over
_PAGES = {"/": ("index.html", "text/html"), "/console.js": ("console.js", "text/javascript")}
_PAGES["/console.css"] = ("console.css", "text/css")


class NoConsole(InputError):
    """Error, because the web server of the console (page that shows and controls runs) cannot be started."""


class Server:
    """Web server of the console, a page from which runs are watched and operated; runs go on without it."""

    def __init__(self, runs: Path, host: str | None, port: int | None) -> None:
        """Bind the port.

        Args:
            runs: the folder of the runs.
            host: another address than this machine's own two; clients there need the token, too.
            port: the port; None: 8090, or the next free one; 0: any.

        Raises:
            NoConsole: address or port is not available, or the address is that of all interfaces.
        """
        if host in _EVERY:
            wrong = "pages of any name would reach it"
            raise NoConsole(f"--host {host}: {wrong}; allowed: one address of this machine, or its name")
        self._runs = runs
        self._sockets = _sockets((host,) if host else LOOPBACK_ADDRESSES, port)
        self.port = int(self._sockets[0].getsockname()[1])
        names = [host] if host else ["127.0.0.1", "localhost", "::1"]
        shown = [f"[{name}]" if ":" in name else name for name in names]
        self._guard = Guard([f"{item}:{self.port}" for item in shown])
        self.address = f"http://{shown[0]}:{self.port}/#token={self._guard.token}"
        """URL of the page, with the token after `#`, a part that browsers neither send nor log."""

    def serve(self, over: Callable[[], bool]) -> None:
        """Serve requests until `over` returns True."""
        asyncio.run(self._serve(over))

    def close(self) -> None:
        """Release the port; a second call does nothing."""
        for item in self._sockets:
            item.close()

    async def _serve(self, over: Callable[[], bool]) -> None:
        watcher, connections = Watcher(self._runs), Connections(self._guard.has_token)
        app = web.Application(middlewares=[connections.heard, self._guard.check], client_max_size=MOST_BODY)
        app.add_routes(Handlers(watcher).routes())
        app.add_routes([web.get(path, _page(*page)) for path, page in _PAGES.items()])
        app.add_routes([web.get("/favicon.ico", _no_picture)])
        runner = web.AppRunner(
            app, access_log=None, logger=_unheard(), keepalive_timeout=KEPT_S, shutdown_timeout=0.5
        )
        await runner.setup()
        assert runner.server is not None
        connections.of = runner.server
        loop = asyncio.get_running_loop()
        listening = [
            await loop.create_server(connections, sock=item, backlog=ACCEPTED_AT_ONCE)
            for item in self._sockets
        ]
        for item in self._sockets:
            item.listen(WAITING_TO_BE_ACCEPTED)
        watching = asyncio.create_task(watcher.watch())
        try:
            while not over():
                await asyncio.sleep(_LOOKS_S)
                if watching.done():
                    watching.result()
        finally:
            watching.cancel()
            with suppress(asyncio.CancelledError):
                await watching
            await accept_no_more(self._sockets)
            for server in listening:
                server.close()
            watcher.close()
            await runner.cleanup()


def _unheard() -> logging.Logger:
    """Return a logger that drops aiohttp's messages on invalid requests, which would fill the terminal."""
    logger = logging.getLogger(__name__)
    logger.addHandler(logging.NullHandler())
    logger.propagate = False
    logger.setLevel(logging.CRITICAL)
    return logger


def _page(name: str, kind: str) -> Handler:
    content = files(__package__).joinpath("page", name).read_bytes()

    async def give(_: web.Request) -> web.Response:
        return web.Response(body=content, content_type=kind, charset="utf-8")

    return give


async def _no_picture(_: web.Request) -> web.Response:
    return web.Response(status=204)


def _sockets(hosts: Sequence[str], port: int | None) -> list[socket.socket]:
    """Return sockets that listen at the same port of each address of this machine."""
    wrong = ""
    for chosen in range(PORT, PORT + TRIES) if port is None else (port,):
        opened: list[socket.socket] = []
        try:
            for host in hosts:
                opened.append(_opened(host, opened[0].getsockname()[1] if opened else chosen))
        except OSError as error:
            if opened and hosts == LOOPBACK_ADDRESSES and not _has_ipv6():
                return opened
            for socket_ in opened:
                socket_.close()
            wrong = error.strerror or str(error)
            continue
        return opened
    asked = f"port {port}" if port is not None else f"any port from {PORT} to {PORT + TRIES - 1}"
    raise NoConsole(f"{asked} of {hosts[0]} can't be listened on: {wrong}; allowed: a free one, or 0 for any")


def _opened(host: str, port: int) -> socket.socket:
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    made = socket.socket(family)
    try:
        made.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        if family == socket.AF_INET6:
            made.setsockopt(socket.IPPROTO_IPV6, socket.IPV6_V6ONLY, 1)
        made.bind((host, port))
        made.listen(WAITING_TO_BE_ACCEPTED)
    except OSError:
        made.close()
        raise
    return made


def _has_ipv6() -> bool:
    try:
        with socket.socket(socket.AF_INET6) as tried:
            tried.bind((LOOPBACK_ADDRESSES[1], 0))
    except OSError:
        return False
    return True
