"""Orderly end of a local server, without sockets left open."""

from __future__ import annotations

import asyncio
from collections.abc import Iterable
from socket import socket

SETUP_ROUNDS = 5
"""Rounds of the event loop until an accepted connection is set up and can be closed."""


async def accept_no_more(listening: Iterable[socket]) -> None:
    """Accept no more connections, wait until the accepted ones are set up, and close the server.

    A server that is closed earlier loses them: asyncio asserts that it still has its sockets, and never
    closes the connections that it accepted (CPython issue 79033).
    """
    loop = asyncio.get_running_loop()
    for socket_ in listening:
        loop.remove_reader(socket_.fileno())
    for _ in range(SETUP_ROUNDS):
        await asyncio.sleep(0)
