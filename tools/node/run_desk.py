"""Requests for runs, and acknowledgements, by services of ROS 2."""

from __future__ import annotations

import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import IO, Any, NamedTuple

import orjson

from handcart.backends.ros2.wire.serving_link import Answer, ServingLink
from handcart.evaluation.viewing.node.door import SERVICE_PREFIX
from handcart.files.errors import HandcartError
from handcart.networks.journal.waiting import is_simulated, waiting
from handcart.networks.operator.acknowledging import acknowledge, cause_of
from handcart.networks.operator.asking import goes_on
from handcart.networks.run_files.run_folder import JOURNAL_FILE, read_run_journal
from handcart.networks.run_files.run_names import list_runs
from handcart.networks.run_files.socket_path import CONTROL_SOCKET

START_TIMEOUT_S = 60.0
"""[s] within which a requested run has to begin, or to refuse."""
POLL_PERIOD_S = 0.1
READ_S = 1.0
"""[s] for which a new reason has to be published before it can be acknowledged."""
Starter = Callable[[Sequence[str], IO[bytes]], "subprocess.Popen[bytes]"]


class WaitingRecord(NamedTuple):
    """A record of a run that waits for a person."""

    run: Path
    record: int
    cause: str
    """Checksum of what it waits for."""
    reason: str
    is_real: bool
    """True if a real robot waits with it: nothing else may begin."""


def start_apart(words: Sequence[str], said: IO[bytes]) -> subprocess.Popen[bytes]:
    """Start a program in a new session (`setsid`), so that it outlives this one; its output goes to a
    file.
    """
    return subprocess.Popen(words, stdin=subprocess.DEVNULL, stdout=said, stderr=said, start_new_session=True)


class RunDesk:
    """Starts one run at a time, each a process of its own, and acknowledges what waits in the last one.

    The run itself decides whether the robot is free, as if it was started at a terminal.
    """

    def __init__(
        self,
        tasks: Mapping[str, Path],
        runs: Path,
        options: Sequence[str] = (),
        start: Starter = start_apart,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Offer tasks.

        Args:
            tasks: their files by the last part of their services' names.
            runs: folder of the runs.
            options: further options of `handcart run`.
            start: starts a program.
            clock: gives a time in [s].
        """
        self._tasks, self._runs, self._options = tasks, runs, tuple(options)
        self._start, self._clock = start, clock
        self._child: subprocess.Popen[bytes] | None = None
        self._read: tuple[WaitingRecord | None, float] = (None, 0.0)

    def offer(self, link: ServingLink) -> None:
        """Offer all services."""
        for name in self._tasks:
            link.serve(f"{SERVICE_PREFIX}/run/{name}", lambda name=name: self.request(name))  # type: ignore[misc]
        link.serve(f"{SERVICE_PREFIX}/acknowledge", self.acknowledge)

    def state(self) -> dict[str, Any]:
        """Return the offered tasks, the running run, and what waits for a person; people read it now."""
        waits = self._waits()
        if waits != self._read[0]:
            self._read = waits, self._clock()
        alive = self._alive()
        shown = None if waits is None else {"run": str(waits.run), "reason": waits.reason}
        return {"tasks": sorted(self._tasks), "running": alive and str(alive), "waits": shown}

    def request(self, name: str) -> Answer:
        """Start a run of a task, unless one is running or waits; answer once it has begun, or refused."""
        alive = self._alive()
        if alive is not None or self._is_running():
            return Answer(False, f"{alive or 'a run'} is running; allowed: one at a time")
        waits = self._waits()
        if waits is not None and waits.is_real:
            how = f"when all is safe: {SERVICE_PREFIX}/acknowledge"
            return Answer(False, f"the last run, {waits.run}, waits for a person: {waits.reason}; {how}")
        words = [sys.executable, "-m", "handcart", "run", str(self._tasks[name]), "--node"]
        with tempfile.TemporaryFile() as said:
            self._child = self._start([*words, "--runs", str(self._runs), *self._options], said)
            end = self._clock() + START_TIMEOUT_S
            while self._clock() < end:
                if self._child.poll() is not None:
                    return Answer(False, _last_line(said) or f"it ended with {self._child.returncode}")
                begun = self._alive()
                if begun is not None:
                    return Answer(True, f"{name} runs in {begun}")
                time.sleep(POLL_PERIOD_S)
        return Answer(False, f"it has not begun within {START_TIMEOUT_S:g} s; it may still begin")

    def acknowledge(self) -> Answer:
        """Acknowledge what waits in the last run, if people could read it before."""
        waits, since = self._read
        if waits is None:
            return Answer(False, "no run waits for a person")
        if self._clock() - since < READ_S:
            return Answer(False, f"its reason is new; read it in {SERVICE_PREFIX}/desk, and call again")
        try:
            return Answer(True, acknowledge(waits.run, waits.record, waits.cause))
        except HandcartError as error:
            return Answer(False, str(error))

    def _is_running(self) -> bool:
        return self._child is not None and self._child.poll() is None

    def _alive(self) -> Path | None:
        """Return the folder of a run that is alive and listens; None if there is none."""
        for run in list_runs(self._runs) if self._runs.is_dir() else ():
            try:
                if (run.folder / CONTROL_SOCKET).exists() and goes_on(run.folder):
                    return run.folder
            except OSError:
                continue
        return None

    def _waits(self) -> WaitingRecord | None:
        """Return what waits in the newest run that is not alive."""
        listed = list_runs(self._runs) if self._runs.is_dir() else []
        for run in listed[:1]:
            try:
                if not (run.folder / JOURNAL_FILE).exists() or goes_on(run.folder):
                    return None
                contents = read_run_journal(run.folder)
            except (HandcartError, OSError):
                return None
            for record, reason in waiting(contents).items():
                cause, real = str(cause_of(contents, record)["h"]), not is_simulated(contents)
                return WaitingRecord(run.folder, record, cause, reason, real)
        return None


def service_names(tasks: Sequence[Path]) -> dict[str, Path]:
    """Return tasks by names that ROS accepts; the folder's name for a `task.yaml`, others get a number."""
    found: dict[str, Path] = {}
    for task in tasks:
        plain = re.sub(r"\W", "_", task.parent.name if task.stem == "task" else task.stem, flags=re.ASCII)
        name, number = plain if plain[:1].isalpha() else f"task_{plain}", 2
        while name in found:
            name, number = f"{plain}_{number}", number + 1
        found[name] = task.resolve()
    return found


def state_text(state: Mapping[str, Any]) -> str:
    """Return a state as JSON."""
    return orjson.dumps(dict(state)).decode()


def _last_line(said: IO[bytes]) -> str:
    said.seek(0)
    lines = said.read().decode(errors="replace").strip().splitlines()
    return lines[-1] if lines else ""
