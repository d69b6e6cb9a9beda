"""Orderly end of a local server, without sockets left open."""

from __future__ import annotations

import asyncio
from collections.abc import Iterable
from socket import socket

SETUP_ROUNDS = 5
"""Rounds of the event loop until an accepted connection is set up and can be closed."""


async def accept_no_more(listening: Iterable[socket]) -> None:
    """Prepare a server for closing: accept no more connections, and wait until the accepted ones are set up.

    A server that is closed earlier never closes connections that it has just accepted, because an assertion
    of asyncio fails (CPython issue 79033).

    Args:
        listening: sockets on which the server listens.
    """
    loop = asyncio.get_running_loop()
    for socket_ in listening:
        loop.remove_reader(socket_.fileno())
    for _ in range(SETUP_ROUNDS):
        await asyncio.sleep(0)
