"""How a server of this machine comes to its end without leaving sockets open."""

from __future__ import annotations

import asyncio
from collections.abc import Iterable
from socket import socket

SETUP_ROUNDS = 5
"""Of the event loop, until a connection that was accepted is set up and can be closed."""


async def accept_no_more(listening: Iterable[socket]) -> None:
    """Accept no more connections, and wait until those that were accepted are set up; then close the server.

    A server that is closed before loses them: asyncio asserts that it still has its sockets, and never closes
    what it accepted (CPython issue 79033).
    """
    loop = asyncio.get_running_loop()
    for each in listening:
        loop.remove_reader(each.fileno())
    for _ in range(SETUP_ROUNDS):
        await asyncio.sleep(0)
