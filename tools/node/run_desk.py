"""Requests for runs, acknowledgements and resumes by services of ROS 2."""

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
from handcart.networks.journal.journal_record import JournalContents
from handcart.networks.journal.waiting import is_simulated, waiting
from handcart.networks.operator.acknowledging import acknowledge, cause_of
from handcart.networks.operator.asking import goes_on
from handcart.networks.run_files.run_folder import JOURNAL_FILE, read_run_journal
from handcart.networks.run_files.run_names import list_runs
from handcart.networks.run_files.socket_path import CONTROL_SOCKET
from handcart.networks.runs.resuming import task_of

START_TIMEOUT_S = 60.0
"""[s] within which a requested run has to begin, or to refuse."""
RESUME_TIMEOUT_S = 120.0
"""[s] within which a resumed run has to go on: the node of its killed program may stay for a minute."""
POLL_PERIOD_S = 0.1
READ_S = 1.0
"""[s] for which a new state has to be published before it can be acknowledged or resumed."""
Starter = Callable[[Sequence[str], IO[bytes]], "subprocess.Popen[bytes]"]


class WaitingRecord(NamedTuple):
    """Journal record for which a run waits, until a person has acknowledged it."""

    record: int
    cause: str
    """Checksum of the cause of the wait."""
    reason: str
    is_real: bool
    """True if a real robot waits with it: nothing else may begin."""


class LastRun(NamedTuple):
    """State of the newest run after its process has ended, read from its journal."""

    folder: Path
    record: int
    """Number of its journal's last record."""
    end: str
    """How the run ended, in words."""
    waits: WaitingRecord | None
    obstacle: str
    """Reason why the run cannot be resumed; "" if it can."""


def start_apart(words: Sequence[str], said: IO[bytes]) -> subprocess.Popen[bytes]:
    """Start a program in a new session (`setsid`), so that it continues when this program ends.

    Args:
        words: command and arguments.
        said: open file that receives stdout and stderr.
    """
    return subprocess.Popen(words, stdin=subprocess.DEVNULL, stdout=said, stderr=said, start_new_session=True)


class RunDesk:
    """Server of requests to start or resume runs, one at a time, each in a process of its own.

    It also acknowledges records of a run that wait for a person. The run itself decides whether the robot is
    free, as does a run that is started at a terminal.
    """

    def __init__(
        self,
        tasks: Mapping[str, Path],
        runs: Path,
        options: Sequence[str] = (),
        node_options: Sequence[str] = (),
        start: Starter = start_apart,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Offer tasks.

        Args:
            tasks: their files by the last part of their services' names.
            runs: folder of the runs.
            options: further options of `handcart run`.
            node_options: further options of `handcart run` and `handcart resume`.
            start: starts a program.
            clock: gives a time in [s].
        """
        self._tasks, self._runs = tasks, runs
        self._options, self._node_options = tuple(options), tuple(node_options)
        self._start, self._clock = start, clock
        self._child: subprocess.Popen[bytes] | None = None
        self._read: tuple[LastRun | None, float] = (None, 0.0)
        self._looked: tuple[object, LastRun | None] = (None, None)

    def offer(self, link: ServingLink) -> None:
        """Offer the services that start a run of each task, acknowledge a record, and resume a run."""
        for name in self._tasks:
            link.serve(f"{SERVICE_PREFIX}/run/{name}", lambda name=name: self.request(name))  # type: ignore[misc]
        link.serve(f"{SERVICE_PREFIX}/acknowledge", self.acknowledge)
        link.serve(f"{SERVICE_PREFIX}/resume", self.resume)

    def state(self) -> dict[str, Any]:
        """Return the tasks on offer, the running run, the stopped run that waits for a person, and the run
        that can be resumed.

        The caller publishes this state, so that people can read it. A run can be acknowledged or resumed only
        `READ_S` after this method first returned it.
        """
        last = self._last()
        if last != self._read[0]:
            self._read = last, self._clock()
        alive = self._alive()
        waits = resumable = None
        if last is not None and last.waits is not None:
            waits = {"run": str(last.folder), "reason": last.waits.reason}
        if last is not None and not last.obstacle:
            resumable = {"run": str(last.folder), "record": last.record, "end": last.end}
        running = alive and str(alive)
        return {"tasks": sorted(self._tasks), "running": running, "waits": waits, "resumable": resumable}

    def request(self, name: str) -> Answer:
        """Start a run of a task, unless a run is running or waits for a person.

        The answer comes once the run has begun, or was refused.
        """
        if busy := self._busy():
            return Answer(False, busy)
        last = self._last()
        if last is not None and last.waits is not None and last.waits.is_real:
            how = f"when all is safe: {SERVICE_PREFIX}/acknowledge, or {SERVICE_PREFIX}/resume"
            words = f"the last run, {last.folder}, waits for a person: {last.waits.reason}; {how}"
            return Answer(False, words)
        command = ["run", str(self._tasks[name]), "--node", "--runs", str(self._runs), *self._options]
        return self._started(command, START_TIMEOUT_S, self._alive, f"{name} runs in")

    def acknowledge(self) -> Answer:
        """Acknowledge the record of the last run's journal that waits for a person.

        This is refused if the reason for waiting was published less than `READ_S` seconds ago, because the
        caller may not have read it.
        """
        last, since = self._read
        if last is None or last.waits is None:
            return Answer(False, "no run waits for a person")
        if self._clock() - since < READ_S:
            return Answer(
                False, f"its reason was not read before; read it in {SERVICE_PREFIX}/desk, and call again"
            )
        try:
            return Answer(True, acknowledge(last.folder, last.waits.record, last.waits.cause))
        except HandcartError as error:
            return Answer(False, str(error))

    def resume(self) -> Answer:
        """Resume the last run, if its end was published so long ago that the caller can have read it.

        The answer comes once the run continues, or was refused. The run itself decides whether it continues,
        as with `handcart resume --confirm RECORD`: a real robot has to be where it was left.
        """
        if busy := self._busy():
            return Answer(False, busy)
        last, since = self._read
        if last is None or last.obstacle:
            return Answer(False, "there is no run yet" if last is None else last.obstacle)
        if self._clock() - since < READ_S or self._last() != last:
            return Answer(
                False, f"its state was not read before; read it in {SERVICE_PREFIX}/desk, and call again"
            )
        words = ["resume", str(last.folder), "--node", "--confirm", str(last.record)]
        return self._started(words, RESUME_TIMEOUT_S, lambda: _resumed(last), "resumed:")

    def _started(
        self, words: Sequence[str], seconds: float, begun: Callable[[], Path | None], said: str
    ) -> Answer:
        """Start a program, and answer once `begun` returns its run's folder, or with the program's last
        words.

        Args:
            words: the command and its arguments.
            seconds: time within which it has to begin, in [s].
            begun: returns the run's folder once the run has begun; None before.
            said: text of the answer once it has begun.
        """
        command = [sys.executable, "-m", "handcart", *words, *self._node_options]
        with tempfile.TemporaryFile() as output:
            self._child = self._start(command, output)
            end = self._clock() + seconds
            while self._clock() < end:
                over = self._child.poll() is not None
                if folder := begun():
                    return Answer(True, f"{said} {folder}")
                if over:
                    return Answer(
                        False, _last_line(output) or f"the program ended with status {self._child.returncode}"
                    )
                time.sleep(POLL_PERIOD_S)
        return Answer(False, f"it has not begun within {seconds:g} s; it may still begin")

    def _busy(self) -> str:
        """Return which run is running; "" if none is."""
        alive = self._alive()
        if alive is None and (self._child is None or self._child.poll() is not None):
            return ""
        return f"{alive or 'a run'} is running; allowed: one at a time"

    def _alive(self) -> Path | None:
        """Return the folder of a run that is alive and listens; None if there is none."""
        for run in list_runs(self._runs) if self._runs.is_dir() else ():
            try:
                if (run.folder / CONTROL_SOCKET).exists() and goes_on(run.folder):
                    return run.folder
            except OSError:
                continue
        return None

    def _last(self) -> LastRun | None:
        """Return the state of the newest run; None if there is none, or it is alive."""
        listed = list_runs(self._runs) if self._runs.is_dir() else []
        if not listed:
            return None
        folder = listed[0].folder
        try:
            found = (folder / JOURNAL_FILE).stat()
            if goes_on(folder):
                return None
            seen = (folder, found.st_mtime_ns, found.st_size)
            if seen != self._looked[0]:
                self._looked = seen, _last_run(folder)
        except OSError:
            return None
        return self._looked[1]


def _last_run(folder: Path) -> LastRun:
    """Return the state of a run by its journal."""
    try:
        contents = read_run_journal(folder)
    except HandcartError as error:
        return LastRun(folder, -1, "its journal can't be read", None, str(error))
    waits = next(
        (
            WaitingRecord(number, str(cause_of(contents, number)["h"]), reason, not is_simulated(contents))
            for number, reason in waiting(contents).items()
        ),
        None,
    )
    try:
        task_of(folder)
        obstacle = ""
    except HandcartError as error:
        obstacle = str(error)
    return LastRun(folder, len(contents.records) - 1, _end_words(contents), waits, obstacle)


def _end_words(contents: JournalContents) -> str:
    last = contents.records[-1]
    if last["kind"] == "END":
        return f"{last.get('outcome')} in situation {last.get('situation')}"
    return f"it broke off after record {len(contents.records) - 1}, {last['kind']}"


def _resumed(last: LastRun) -> Path | None:
    """Return the folder of a run once its journal shows that it was resumed."""
    try:
        added = read_run_journal(last.folder).records[last.record + 1 :]
    except (HandcartError, OSError):
        return None
    return last.folder if any(record["kind"] == "EPOCH" for record in added) else None


def service_names(tasks: Sequence[Path]) -> dict[str, Path]:
    """Return task files by the names of the ROS 2 services that start them.

    A name is the file's name, or the folder's for a `task.yaml`, with characters that ROS 2 forbids replaced
    by `_`; equal names get a number appended.
    """
    found: dict[str, Path] = {}
    for task in tasks:
        plain = re.sub(r"\W", "_", task.parent.name if task.stem == "task" else task.stem, flags=re.ASCII)
        plain = plain if plain[:1].isalpha() else f"task_{plain}"
        name, number = plain, 2
        while name in found:
            name, number = f"{plain}_{number}", number + 1
        found[name] = task.resolve()
    return found


def state_text(state: Mapping[str, Any]) -> str:
    """Return the state of runs, as a mapping from `RunDesk.state`, as a JSON text."""
    return orjson.dumps(dict(state)).decode()


def _last_line(said: IO[bytes]) -> str:
    said.seek(0)
    lines = said.read().decode(errors="replace").strip().splitlines()
    return lines[-1] if lines else ""
