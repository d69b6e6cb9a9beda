"""Server of the page, reachable from this machine only."""

from __future__ import annotations

import socket
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout
from io import StringIO
from typing import TYPE_CHECKING, NamedTuple

from handcart.files.errors import InputError
from handcart.files.extras import lack

from .gate import Gate

if TYPE_CHECKING:
    import viser

LOOPBACK_HOST = "127.0.0.1"
FIRST_PORT = 8080
MAX_PORT_TRIES = 100  # ports from the first one on


class NoView(InputError):
    """Error for a run that cannot be shown in the browser."""


class Opened(NamedTuple):
    """A running web server that shows a run in 3D, with the address of its page."""

    server: viser.ViserServer
    address: str
    """URL with the token after `#`, a part that browsers neither send nor log."""


@contextmanager
def open_server(port: int | None, title: str) -> Iterator[Opened]:
    """Serve a page for clients on this machine that have the token, until the context ends.

    Args:
        port: the port; None: 8080 or the next free one; 0: any free one.
        title: title over the page's panel.

    Raises:
        NoView: the port is taken, or viser is not installed or cannot be guarded.
    """
    if wrong := lack("the view", "view"):
        raise NoView(wrong)
    import viser

    chosen = _free(port)
    gate = Gate(f"{LOOPBACK_HOST}:{chosen}")
    with gate.before_servers(), redirect_stdout(StringIO()):  # viser prints a greeting
        server = viser.ViserServer(host=LOOPBACK_HOST, port=chosen, label=title, verbose=False)
    try:
        if not gate.guards:
            raise NoView(f"viser {viser.__version__} can't be guarded against strangers; known: 1.1")
        if server.get_port() != chosen:
            raise NoView(f"the port {chosen} was taken meanwhile; try again")
        # Sharing would publish the page outside this machine.
        server.gui.configure_theme(control_width="large", show_logo=False, show_share_button=False)
        server.gui.main_panel.dock_right()
        server.scene.set_up_direction("+z")
        yield Opened(server, f"http://{LOOPBACK_HOST}:{chosen}/#token={gate.token}")
    finally:
        with redirect_stdout(StringIO()):
            server.stop()


def _free(port: int | None) -> int:
    for chosen in range(FIRST_PORT, FIRST_PORT + MAX_PORT_TRIES) if port is None else (port,):
        with socket.socket() as tried:
            tried.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            try:
                tried.bind((LOOPBACK_HOST, chosen))
                return int(tried.getsockname()[1])
            except OSError as error:
                wrong = error.strerror
    asked = (
        f"the port {port}"
        if port is not None
        else f"any port from {FIRST_PORT} to {FIRST_PORT + MAX_PORT_TRIES - 1}"
    )
    raise NoView(f"--port: {asked} can't be listened on: {wrong}; allowed: a free one, or 0 for any")
