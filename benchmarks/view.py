"""Measure the cost of viewing a run.

`python -m benchmarks.view cost TASK` prints how much longer a recorded run takes. `python -m
benchmarks.view open RUN` prints how long a recorded run takes to open: from the command's start to the
served page, and with chromium until the page is drawn. Then the time of a frame while scrubbing.
"""

from __future__ import annotations

import argparse
import http.client
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from handcart.evaluation.viewing.playback.part import PLAYBACK_FOLDER
from handcart.evaluation.viewing.playback.playback import Playback

REPEAT_COUNT = 5
FRAME_COUNT = 300
FRAME_PERIOD_S = 1.0 / 25.0  # [s] of a frame that doesn't stutter


def main() -> None:
    """One of the two."""
    words = argparse.ArgumentParser(description=__doc__)
    words.add_argument("what", choices=("cost", "open"))
    words.add_argument("path", type=Path, help="of a task file to run, or of a recorded run's folder")
    wanted = words.parse_args()
    if wanted.what == "cost":
        cost(wanted.path)
    else:
        opening(wanted.path)
        scrubbing(wanted.path)


def cost(task: Path) -> None:
    """CPU of a run with and without being recorded, in turns; the least of each."""
    from handcart.evaluation.trials.running import run_task
    from handcart.networks.runs.run_options import RunOptions

    spent: dict[bool, list[float]] = {False: [], True: []}
    size, lasted = 0, 0.0
    with TemporaryDirectory() as there:
        run_task(task, Path(there), RunOptions())  # compiling counts for neither
        for _ in range(REPEAT_COUNT):
            for playback in (False, True):
                before = time.process_time()
                summary, _ = run_task(task, Path(there), RunOptions(playback=playback))
                spent[playback].append(time.process_time() - before)
            size = sum(path.stat().st_size for path in (Path(summary["run_dir"]) / PLAYBACK_FOLDER).iterdir())
            lasted = summary["sim_time_s"]
    bare, recorded = min(spent[False]), min(spent[True])
    print(
        f"{task}: {bare:.2f} s of CPU, recorded {recorded:.2f} s: {100.0 * (recorded / bare - 1.0):+.1f} %; "
        f"{size / 1e6:.2f} MB for {lasted:.0f} s of the robot's time"
    )
    print(
        "  bare:",
        *(f"{value:.2f}" for value in spent[False]),
        " recorded:",
        *(f"{e:.2f}" for e in spent[True]),
    )


def opening(run: Path) -> None:
    """Print the times from the command's start to the page."""
    playback = Playback.read(run)
    rows, pictures = playback.rows, len(playback.pictures)
    print(
        f"{run}: {playback.end - playback.start:.0f} s, {len(rows.time)} rows, {len(rows.scan_time)} scans, "
        f"{pictures} pictures, {len(playback.things)} things"
    )
    for _ in range(REPEAT_COUNT):
        before = time.perf_counter()
        command = [sys.executable, "-m", "handcart", "view", str(run), "--port", "0"]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
            assert process.stdout is not None
            found = re.search(r"http://([\d.]+):(\d+)/#token=\S+", process.stdout.readline())
            assert found
            page = http.client.HTTPConnection(found[1], int(found[2]))
            page.request("GET", "/")
            page.getresponse().read()
            served = time.perf_counter() - before
            loaded = _loaded(found[0])
            process.send_signal(signal.SIGINT)
            _, status, used = os.wait4(process.pid, 0)
            process.returncode = os.waitstatus_to_exitcode(status)
        drawn = "" if loaded is None else f"; then drawn by a chromium without a GPU in {loaded:.2f} s"
        cpu = used.ru_utime + used.ru_stime
        print(f"  served whole after {served:.2f} s{drawn}; the command took {cpu:.2f} s of CPU in all")


def _loaded(url: str) -> float | None:
    """Return the time until the panel of an open browser shows the run [s]; None without a browser."""
    from tests.browser import CHROMIUM, DESK, browsing

    if not CHROMIUM.exists():
        return None
    with browsing(DESK) as seen:
        before = time.perf_counter()
        seen.page.goto(url)
        seen.page.locator("canvas").first.wait_for()
        seen.page.get_by_text(re.compile(r"^\d+\.\d s$")).first.wait_for()
        return time.perf_counter() - before


def scrubbing(run: Path) -> None:
    """Frames at random times, as by a hand that pulls the slider: until each is handed to the browser."""
    from handcart.evaluation.viewing.view.replay import Replay
    from handcart.evaluation.viewing.view.serving.server import open_server

    playback = Playback.read(run)
    times = np.random.default_rng(0).uniform(playback.start, playback.end, FRAME_COUNT)
    with open_server(0, "benchmark") as (server, _):
        replay = Replay(server, playback)
        took = []
        for item in times.tolist():
            before = time.perf_counter()
            replay.go_to(item)
            replay.step(0.0)
            took.append(time.perf_counter() - before)
    half, most, worst = 1e3 * np.percentile(took, [50, 99, 100])
    late = np.mean(np.array(took) > FRAME_PERIOD_S)
    print(
        f"  scrubbed to {FRAME_COUNT} random times: a frame in {half:.1f} ms (median), {most:.1f} ms (99 %), "
        f"{worst:.1f} ms (worst); {100 * late:.1f} % took more than {1e3 * FRAME_PERIOD_S:.0f} ms"
    )


if __name__ == "__main__":
    main()
