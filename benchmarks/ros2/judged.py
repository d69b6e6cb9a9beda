"""Trials that are judged, and those in which the machine itself was too slow."""

from __future__ import annotations

import math
import os
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

LATE_LIMIT_S = 0.05
"""[s] by which no period of bench and program may be too long in a trial that is judged: one period."""
QUEUE_FILE = Path("/proc/thread-self/schedstat")
"""Times of the calling thread in [ns] as Linux counts them: on a core, and ready to run without a core."""


class Lateness(NamedTuple):
    """Time by which a period of a loop was too long, at most, by its two causes."""

    machine_s: float = 0.0
    """Share in [s] in which the loop's thread was ready to run, but had no core."""
    own_s: float = 0.0
    """All other lateness in [s]: the loop computed or waited for something; all of it if not `is_split`."""
    is_split: bool = True
    """False where the system does not count how long a thread has no core."""


class Verdict(NamedTuple):
    """Result of a trial."""

    wrong: str
    """Why it counts as missed, its lateness aside; "" if it doesn't."""
    late: Lateness
    """Lateness of its bench and program."""

    @property
    def is_judged(self) -> bool:
        """Return whether the machine was fast enough; the result of the trial plays no part.

        A loop that was late by itself is judged however busy the machine was, and so is every loop whose
        lateness has no known cause.
        """
        return not self.late.is_split or self.late.machine_s <= LATE_LIMIT_S or self._is_late_itself

    @property
    def finding(self) -> str:
        """Why it counts as missed, its own lateness included; "" if it doesn't."""
        late = f"a loop was {self.late.own_s:.2f} s late by itself" if self._is_late_itself else ""
        return "; ".join(filter(None, (self.wrong, late)))

    @property
    def _is_late_itself(self) -> bool:
        return self.late.is_split and self.late.own_s > LATE_LIMIT_S


class Tally:
    """Counts of one row: judged trials, and those that are not because the machine had no core for a loop.

    Bench and program have to keep their period. Where the machine lets one of both wait for a core, a
    message that is missing or a base that rests late says nothing of the program. Such a trial is not
    judged, whether it was good or not, and counted apart. A loop that is late by itself is a miss.
    """

    def __init__(self, verdicts: Sequence[Verdict]) -> None:
        """Count the trials of a row."""
        self._judged = [verdict for verdict in verdicts if verdict.is_judged]
        self._others = [verdict for verdict in verdicts if not verdict.is_judged]

    @property
    def missed(self) -> int:
        """Number of judged trials that were missed; a row without a judged trial counts as one."""
        return sum(bool(verdict.finding) for verdict in self._judged) if self._judged else 1

    @property
    def words(self) -> str:
        """Counts, such as `17/18, not judged 2 (a loop had no core for up to 0.31 s; 1 of them good)`."""
        good = sum(not verdict.finding for verdict in self._judged)
        counts = f"{good}/{len(self._judged)}"
        unknown = [verdict.late.own_s for verdict in self._judged if not verdict.late.is_split]
        if unknown:
            counts += f" (loops up to {max(unknown):.2f} s late, judged all: no {QUEUE_FILE} on this system)"
        if not self._others:
            return counts
        late = max(verdict.late.machine_s for verdict in self._others)
        fine = sum(not verdict.wrong for verdict in self._others)
        apart = f"a loop had no core for up to {late:.2f} s; {fine} of them good"
        return f"{counts}, not judged {len(self._others)} ({apart})"

    def findings(self) -> Iterator[str]:
        """Yield each reason of a missed trial once, those that are not judged last."""
        for verdicts, mark in ((self._judged, ""), (self._others, "not judged: ")):
            for finding in dict.fromkeys(verdict.finding for verdict in verdicts if verdict.finding):
                yield f"{mark}{finding}"


class QueueClock:
    """Time for which the thread that makes it was ready to run but had no core."""

    def __init__(self, file: Path = QUEUE_FILE) -> None:
        """Begin to read; `file` is Linux' `schedstat` of the calling thread."""
        try:
            self._file = os.open(file.resolve(), os.O_RDONLY)
        except OSError:
            self._file = -1

    def read_s(self) -> float:
        """Return the time so far in [s]; NaN where the system does not count it."""
        if self._file < 0:
            return math.nan
        ran, waited = os.pread(self._file, 80, 0).split()[:2]
        return int(waited) / 1e9 if int(ran) else math.nan  # a thread that reads this has run


class LoopWatch:
    """Longest period of this process' loop, readable by the parent as `Process.late`."""

    shared: Any = None
    """Shared numbers of the parent, as of `Lateness`; None outside of a `Process`."""

    def __init__(self, period_s: float, skipped: int = 0, queue: QueueClock | None = None) -> None:
        """Begin with a first period.

        Args:
            period_s: duration of a period in [s].
            skipped: number of first periods that do not count: in these, functions are loaded and compiled.
            queue: clock of the calling thread; None: that of Linux.
        """
        self._queue = queue or QueueClock()
        self._period_s, self._ended, self._waited = period_s, time.monotonic(), self._queue.read_s()
        self._found: list[Lateness] = []
        self._skipped = skipped

    def note(self) -> None:
        """Note that a period has ended."""
        now, waited = time.monotonic(), self._queue.read_s()
        late = split_lateness(now - self._ended - self._period_s, waited - self._waited)
        self._ended, self._waited = now, waited
        if self._skipped > 0:
            self._skipped -= 1
            return
        self._found.append(late)
        if self.shared is not None:
            self.shared[:] = most_late((Lateness(*self.shared), late))

    def figures(self) -> dict[str, float]:
        """Return by how much 99 % of the periods are too long at most, by each cause, in [ms]."""
        shares = [(late.machine_s, late.own_s) for late in self._found if late.is_split]
        if not shares:
            return {}
        machine, own = (round(1e3 * float(share), 3) for share in np.percentile(shares, 99.0, axis=0))
        return {"machine_p99_ms": machine, "own_p99_ms": own}


def split_lateness(late_s: float, waited_s: float) -> Lateness:
    """Split the lateness of a period.

    Args:
        late_s: time in [s] by which it was too long; negative if it was too short.
        waited_s: time in [s] without a core in it; NaN if unknown.
    """
    late_s = max(0.0, late_s)
    if math.isnan(waited_s):
        return Lateness(0.0, late_s, is_split=False)
    machine_s = min(late_s, waited_s)
    return Lateness(machine_s, late_s - machine_s)


def most_late(found: Sequence[Lateness]) -> Lateness:
    """Return the most of each share; none is split if one of them is not."""
    machine = max((late.machine_s for late in found), default=0.0)
    own = max((late.own_s for late in found), default=0.0)
    return Lateness(machine, own, all(late.is_split for late in found))
