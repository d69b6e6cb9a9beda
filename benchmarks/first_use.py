"""Measure the first use of a command: `python -m benchmarks.first_use [COMMAND ...]`

Each command runs in a process of its own with an empty folder for machine code, as after installing.
Prints the wall times until its first line on stdout or stderr, and until its result: its end, or for `run`
the line before the first motion. Only meaningful on an idle machine.
"""

from __future__ import annotations

import argparse
import math
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from threading import Thread
from typing import IO, NamedTuple

REPOSITORY_ROOT = Path(__file__).resolve().parents[1]
FIRST_MOTION_WORDS = (
    "stops the base",
    "1. DIVIDE",
)  # what `run` says before the first motion; DIVIDE only thinks
TIMED_COMMANDS = {
    "check": ("check", "stack_blocks"),
    "check seam": ("check", "track_seam"),
    "check robot": ("check", "backends/robots/librarian/robot.yaml"),
    "do": ("do", "MOVE_TO", "place=shelf_3"),
    "run": ("run", "return_book", "--no-report"),
    "run blocks": ("run", "stack_blocks", "--no-report"),
    "run seam": ("run", "track_seam", "--no-report"),
    "run field": ("run", "deploy_straight", "--no-report"),
    "localize": ("localize", "{log}", "--columns", "t=t,v=v,w=w,x=x,y=y"),
}
"""Arguments of `handcart` by name."""
MAX_FIRST_LINE_S, MAX_RESULT_S = 2.0, 12.0


class Times(NamedTuple):
    """Seconds by the clock since a command was started."""

    first_line: float
    result: float


def main() -> None:
    """Print the table; status 1 where a row takes longer than it may."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "commands", nargs="*", metavar="COMMAND", help=f"of {', '.join(TIMED_COMMANDS)} (default: all)"
    )
    chosen = parser.parse_args().commands or list(TIMED_COMMANDS)
    if unknown := sorted(set(chosen) - set(TIMED_COMMANDS)):
        parser.error(f"{', '.join(unknown)}: not known; there are {', '.join(TIMED_COMMANDS)}")
    late = False
    limits = f"  (allowed: {MAX_FIRST_LINE_S:g}, {MAX_RESULT_S:g})"
    print(f"{'first use of':14}{'first line s':>14}{'result s':>10}{limits}")
    for name in chosen:
        took = first_use(TIMED_COMMANDS[name])
        late |= took.first_line > MAX_FIRST_LINE_S or took.result > MAX_RESULT_S
        print(f"{name:14}{took.first_line:14.1f}{took.result:10.1f}", flush=True)
    sys.exit(1 if late else 0)


def first_use(words: Sequence[str]) -> Times:
    """Run a command with no machine code on disk, and time it."""
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        log = Path(folder) / "log.csv"
        if "{log}" in words:
            write_log(log)
        command = [sys.executable, "-m", "handcart", *(word.format(log=log) for word in words)]
        if words[0] == "run":
            command += ["--runs", f"{folder}/runs"]
        env = {**os.environ, "NUMBA_CACHE_DIR": f"{folder}/code", "OMP_NUM_THREADS": "1"}
        begun, said = time.monotonic(), list[tuple[float, str]]()
        process = subprocess.Popen(
            command, cwd=REPOSITORY_ROOT, env=env, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )
        assert process.stdout is not None and process.stderr is not None
        pipes = process.stdout, process.stderr
        readers = [Thread(target=_note, args=(pipe, begun, said)) for pipe in pipes]
        for reader in readers:
            reader.start()
        while process.poll() is None and not any(_begins(line) for _, line in list(said)):
            time.sleep(0.02)
        result = time.monotonic() - begun
        process.kill()
        for reader in readers:
            reader.join()
        process.wait()
    return Times(min((at for at, _ in said), default=result), result)


def write_log(path: Path) -> None:
    """Write the log of a car that drives an eight for two minutes, as a CSV file."""
    rows, x, y, heading = ["t,v,w,x,y"], 0.0, 0.0, 0.0
    for number in range(2400):
        rate = 0.1 if number < 1200 else -0.1
        heading += rate * 0.05
        x, y = x + 0.05 * math.cos(heading), y + 0.05 * math.sin(heading)
        off_x, off_y = 0.3 * math.sin(number), 0.3 * math.cos(1.7 * number)
        fix = f"{x + off_x:.3f},{y + off_y:.3f}" if number % 20 == 0 else ","
        rows.append(f"{0.05 * number:.2f},1.0,{rate},{fix}")
    path.write_text("\n".join(rows) + "\n", encoding="utf-8")


def _begins(line: str) -> bool:
    return any(words in line for words in FIRST_MOTION_WORDS)


def _note(pipe: IO[str], begun: float, said: list[tuple[float, str]]) -> None:
    said.extend((time.monotonic() - begun, line) for line in pipe)


if __name__ == "__main__":
    main()
