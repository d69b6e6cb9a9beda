"""Measure how soon the console's commands arrive.

`python -m benchmarks.console` runs tasks/stack_blocks in single steps, presses Permit in a real browser,
and prints the time from each click to the START of its action in the journal, after which the robot moves:
at most one control period and 100 ms. Then the delay of a stop while 50 pages listen and request
everything.
"""

from __future__ import annotations

import argparse
import http.client
import re
import socket
import subprocess
import sys
import threading
import time
from contextlib import suppress
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import orjson

from handcart.networks.run_files.socket_path import STOP_SOCKET, socket_path
from tests.browser import DESK, browsing

REPOSITORY_ROOT = Path(__file__).parents[1]
PERMITS, STOPS, PAGES = 20, 200, 50
PERIOD_S = 0.05


def main() -> None:
    """Both."""
    argparse.ArgumentParser(description=__doc__).parse_args()
    with TemporaryDirectory() as name:
        runs = Path(name) / "runs"
        console = subprocess.Popen(
            [sys.executable, "-m", "handcart", "console", str(runs), "--port", "0"],
            stdout=subprocess.PIPE,
            text=True,
        )
        task = REPOSITORY_ROOT / "tasks" / "stack_blocks" / "task.yaml"
        words = ["run", str(task), "--step", "--no-report", "--runs", str(runs)]
        run = subprocess.Popen(
            [sys.executable, "-m", "handcart", *words],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        try:
            assert console.stdout is not None
            found = re.search(r"http://127\.0\.0\.1:(\d+)/#token=(\S+)", console.stdout.readline())
            assert found
            permits(found.group(), runs / "stack_blocks-0")
            run.kill()
            run.wait()
            stops(int(found.group(1)), found.group(2), runs / "stack_blocks-0")
        finally:
            run.kill()
            console.terminate()
            console.wait()


def permits(url: str, folder: Path) -> None:
    """Print the times from clicks to STARTs."""
    clicks: list[float] = []
    with browsing(DESK) as seen:
        page = seen.page
        page.goto(url)
        page.locator("[data-name=stack_blocks-0] button").click(timeout=60_000)
        page.get_by_label("Your name").fill("Ada")
        page.get_by_role("button", name="Take the command").click()
        for number in range(1, PERMITS + 1):
            page.wait_for_function(
                "n => { const run = current(); return run && run.asks && run.asks.ask === n"
                " && !document.getElementById('permit').disabled; }",
                arg=number,
                timeout=120_000,
            )
            clicks.append(
                page.evaluate(
                    "() => { const now = Date.now(); document.getElementById('permit').click(); return now; }"
                )
                / 1e3
            )
        page.wait_for_timeout(1000)
    records = map(orjson.loads, (folder / "journal.jsonl").read_bytes().splitlines())
    starts = [record["wall"]["unix_s"] for record in records if record["kind"] == "START"]
    took = 1e3 * (np.array(starts[:PERMITS]) - np.array(clicks[: len(starts)]))
    most = 1e3 * PERIOD_S + 100.0
    print(
        f"{len(took)} permits in the browser: START after {np.median(took):.0f} ms (median), "
        f"{took.max():.0f} ms (most; allowed: {most:.0f})"
    )


def stops(port: int, token: str, folder: Path) -> None:
    """Print the delays of stops while 50 other pages send requests."""
    headers = {"Authorization": f"Bearer {token}", "Content-Type": "application/json"}
    over = threading.Event()

    def bother(number: int) -> None:
        listening = http.client.HTTPConnection("127.0.0.1", port)
        mine = {**headers, "X-Console-Tab": f"tab-{number}"}
        listening.request("GET", "/api/events", headers=mine)
        listening.getresponse()
        asking = http.client.HTTPConnection("127.0.0.1", port)
        with suppress(OSError, http.client.HTTPException):  # at the end the console is gone
            while not over.is_set():
                asking.request("GET", f"/api/runs/{folder.name}", headers=mine)
                asking.getresponse().read()

    heard = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
    (folder / STOP_SOCKET).unlink(missing_ok=True)
    with socket_path(folder / STOP_SOCKET) as name:
        heard.bind(name)
    heard.settimeout(10.0)
    others = [threading.Thread(target=bother, args=(number,), daemon=True) for number in range(PAGES)]
    for other in others:
        other.start()
    time.sleep(1.0)
    took = []
    for _ in range(STOPS):
        line = http.client.HTTPConnection("127.0.0.1", port)
        began = time.monotonic()
        line.request("POST", f"/api/runs/{folder.name}/stop", body=b"{}", headers=headers)
        heard.recv(16)
        took.append(1e3 * (time.monotonic() - began))
        line.getresponse().read()
        line.close()
    over.set()
    print(
        f"{STOPS} stops beside {PAGES} pages: {np.median(took):.0f} ms (median), "
        f"{np.quantile(took, 0.99):.0f} ms (99 %; allowed: 100), {max(took):.0f} ms (most)"
    )


if __name__ == "__main__":
    main()
