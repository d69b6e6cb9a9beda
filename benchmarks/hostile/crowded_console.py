"""Measure how soon a STOP arrives through the console while hostile local sockets crowd it.

`python -m benchmarks.hostile.crowded_console` serves a console on this machine alone, lets another process
open 300 sockets to it without the token, again as soon as they are closed, and sends stops at the same
time, each on a new connection. It prints how many arrived within a second, and ends with status 1 unless
all did. Nothing leaves this machine, and it ends after `--longest-s`.
"""

from __future__ import annotations

import argparse
import http.client
import re
import selectors
import socket
import subprocess
import sys
import time
from contextlib import suppress
from multiprocessing import get_context
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from benchmarks.campaigns.walk import walk
from handcart.evaluation.trials.running import run_task
from handcart.networks.run_files.socket_path import STOP_SOCKET, socket_path
from handcart.networks.runs.run_options import RunOptions

HOST_ADDRESS = "127.0.0.1"
ALLOWED_S = 1.0
HOSTILE_REQUESTS = (
    b"",
    b"GET",
    b"GET / HTTP/1.1\r\nHost: ",
    b"GET /api/events HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n\r\n",
)
"""Bytes of hostile sockets: nothing, half a request, or a whole one without the token."""


def main() -> None:
    """Serve, crowd, stop, count."""
    words = argparse.ArgumentParser(description=__doc__)
    words.add_argument("--sockets", type=int, default=300, help="hostile sockets (default: 300)")
    words.add_argument("--stops", type=int, default=100, help="stops that are sent (default: 100)")
    words.add_argument("--longest-s", type=float, default=120.0, help="ends then in any case (default: 120)")
    chosen = words.parse_args()
    print(f"{chosen.sockets} hostile sockets, {chosen.stops} stops; it begins in a few seconds", flush=True)
    with TemporaryDirectory() as name:
        summary, _ = run_task(walk(Path(name)), Path(name) / "runs", RunOptions())
        folder = Path(str(summary["run_dir"]))
        command = [sys.executable, "-m", "handcart", "console", str(folder.parent), "--port", "0"]
        console = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        try:
            assert console.stdout is not None
            found = re.search(r"http://127\.0\.0\.1:(\d+)/#token=(\S+)", console.stdout.readline())
            assert found
            took = crowded_stops(folder, int(found.group(1)), found.group(2), chosen)
        finally:
            console.terminate()
            console.wait()
    arrived = int((took <= ALLOWED_S).sum())
    print(
        f"{arrived} of {chosen.stops} stops arrived within {ALLOWED_S:g} s beside {chosen.sockets} hostile "
        f"sockets: {1e3 * np.median(took):.0f} ms (median), {1e3 * took.max():.0f} ms (most)"
    )
    raise SystemExit(0 if arrived == chosen.stops else 1)


def crowded_stops(folder: Path, port: int, token: str, chosen: argparse.Namespace) -> np.ndarray:
    """Return the delay of each stop [s]; infinity for one that did not arrive."""
    heard = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
    (folder / STOP_SOCKET).unlink(missing_ok=True)
    with socket_path(folder / STOP_SOCKET) as name:
        heard.bind(name)
    heard.settimeout(2.0 * ALLOWED_S)
    context, end = get_context("spawn"), time.monotonic() + chosen.longest_s
    crowd = context.Process(target=crowd_console, args=(port, chosen.sockets, chosen.longest_s), daemon=True)
    crowd.start()
    took = []
    try:
        time.sleep(3.0)
        for number in range(chosen.stops):
            took.append(stop_once(heard, folder.name, port, token) if time.monotonic() < end else np.inf)
            if (number + 1) % 20 == 0:
                print(f"{number + 1} stops sent", flush=True)
    finally:
        crowd.kill()
        crowd.join()
        heard.close()
    return np.array(took)


def stop_once(heard: socket.socket, run: str, port: int, token: str) -> float:
    """Send a stop on a new connection; how long it took to arrive, in [s], or infinity."""
    line = http.client.HTTPConnection(HOST_ADDRESS, port, timeout=2.0 * ALLOWED_S)
    headers = {"Authorization": f"Bearer {token}", "Content-Type": "application/json"}
    begun = time.monotonic()
    try:
        line.request("POST", f"/api/runs/{run}/stop", body=b"{}", headers=headers)
        heard.recv(16)
        took = time.monotonic() - begun
        line.getresponse().read()
        return took
    except (OSError, http.client.HTTPException):
        return np.inf
    finally:
        line.close()


def crowd_console(port: int, count: int, seconds: float) -> None:
    """Keep that many sockets open for that long; one that is hung up on comes again."""
    selector, end, said = selectors.DefaultSelector(), time.monotonic() + seconds, 0
    opened = 0
    while time.monotonic() < end:
        while opened < count:
            with suppress(OSError):
                line = socket.create_connection((HOST_ADDRESS, port), timeout=1.0)
                line.setblocking(False)
                line.send(
                    HOSTILE_REQUESTS[said % len(HOSTILE_REQUESTS)].replace(b"{port}", str(port).encode())
                )
                selector.register(line, selectors.EVENT_READ)
                opened, said = opened + 1, said + 1
        for key, _ in selector.select(0.05):
            line = key.fileobj  # type: ignore[assignment]
            with suppress(OSError):
                if line.recv(65_536):
                    continue
            selector.unregister(line)
            line.close()
            opened -= 1


if __name__ == "__main__":
    main()
