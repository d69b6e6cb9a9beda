"""Send a run invalid messages: `python -m benchmarks.hostile.control 10000 [SEED]`. Status 1: no answer.

Then the delay of `handcart stop` with 50 idle lines, half messages and floods (rows U9, U11).
"""

from __future__ import annotations

import argparse
import json
import socket
import subprocess
import sys
import tempfile
import threading
import time
from contextlib import suppress
from pathlib import Path

from benchmarks.damage.fuzzed_messages import fuzzed_messages
from handcart.networks.journal.journal_record import read_journal
from handcart.networks.operator.asking import ask, goes_on, tell_to_stop

TASK_FILE = Path(__file__).resolve().parents[2] / "tasks" / "return_book" / "task.yaml"
OTHER_CLIENTS = 50
STOP_COUNT = 5
ANSWER_TIMEOUT_S = 30.0  # [s] for one answer


def main() -> None:
    """Print progress, and each message that got no answer."""
    words = argparse.ArgumentParser(description=__doc__)
    words.add_argument("number", nargs="?", type=int, default=10_000)
    words.add_argument("seed", nargs="?", type=int, default=0)
    wanted = words.parse_args()
    count, seed = wanted.number, wanted.seed
    with tempfile.TemporaryDirectory() as runs:
        failures = _fuzzed(Path(runs) / "fuzzed", count, seed)
        print(f"\r{count} messages, {failures} without an answer")
        waits = []
        for number in range(STOP_COUNT):
            waits.append(_stopped(Path(runs) / f"stop{number}"))
            print(f"stopped after {1000 * waits[-1]:.0f} ms, beside {OTHER_CLIENTS} others", flush=True)
    sys.exit(1 if failures else 0)


def _fuzzed(runs: Path, count: int, seed: int) -> int:
    run = Run(runs)
    failures = 0
    for number, message in enumerate(fuzzed_messages(count, seed), start=1):
        try:
            answered = _answered(run.folder, message)
        except OSError as error:
            answered = False
            print(f"\n{error}")
        if not answered:
            failures += 1
            print(f"\n{message[:200]!r}")
        if number % 100 == 0:
            print(f"\r{number} of {count}, {failures} without an answer", end="", flush=True)
        if run.process.poll() is not None:
            print(f"\nthe run ended after {message[:200]!r}")
            return failures + count - number
    run.stop()
    return failures


def _answered(folder: Path, message: bytes) -> bool:
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as line:
        line.settimeout(ANSWER_TIMEOUT_S)
        line.connect(str(folder / "control"))
        with suppress(BrokenPipeError):  # too long: reported, then disconnected
            line.sendall(message + b"\n")
        answer = b""
        while not answer.endswith(b"\n"):
            new = line.recv(1 << 16)
            if not new:
                return False
            answer += new
    reply = json.loads(answer)
    return isinstance(reply["ok"], bool) and "fault" not in reply.get("error", "")


class Run:
    """A run that asks before each action, in a process of its own."""

    def __init__(self, runs: Path, *options: str) -> None:
        words = [sys.executable, "-m", "handcart", "run", str(TASK_FILE), "--runs", str(runs), *options]
        if not options:
            words.append("--step")
        quiet = subprocess.DEVNULL
        self.process = subprocess.Popen(words, stdin=quiet, stdout=quiet, stderr=quiet)
        self.folder = runs / "return_book-0"
        while not (self.folder / "control").exists():
            assert self.process.poll() is None
            time.sleep(0.01)
        ask(self.folder, {"do": "status"}, ANSWER_TIMEOUT_S)

    def stop(self) -> None:
        """Stop it, and wait until its process is over."""
        tell_to_stop(self.folder)
        self.process.wait(60.0)


def _stopped(runs: Path) -> float:
    """Seconds until a run that acts has ended, beside idle lines, half messages and floods."""
    run = Run(runs, "--permit", "always")
    while b'"kind":"START"' not in (run.folder / "journal.jsonl").read_bytes():
        time.sleep(0.01)
    over = threading.Event()
    others = [
        threading.Thread(target=_bother, args=(run.folder, over, index)) for index in range(OTHER_CLIENTS)
    ]
    for other in others:
        other.start()
    time.sleep(1.0)
    asked = time.monotonic()
    tell_to_stop(run.folder)
    while goes_on(run.folder):
        time.sleep(0.002)
    took = time.monotonic() - asked
    over.set()
    for other in others:
        other.join()
    run.process.wait(60.0)
    end = read_journal(run.folder / "journal.jsonl").records[-1]
    assert end["outcome"] == "Cancelled", end
    return took


def _bother(folder: Path, over: threading.Event, number: int) -> None:
    """One of many on the line: silent, half, or all the time."""
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as line:
        line.settimeout(1.0)
        try:
            line.connect(str(folder / "control"))
            if number % 3 == 1:
                line.sendall(b'{"do":"sta')
            while not over.wait(0.05):
                if number % 3 == 2:
                    line.sendall(b'{"do":"status"}\n' * 100)
        except OSError:
            return


if __name__ == "__main__":
    main()
