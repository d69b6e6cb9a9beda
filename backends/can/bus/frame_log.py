"""Every frame of a bus, written as `candump -L` writes it."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from contextlib import suppress
from copy import copy
from pathlib import Path
from typing import NamedTuple, TextIO, cast

import can
from can.io.canutils import CanutilsLogWriter
from typing_extensions import override

from handcart.backends.recording import Recording
from handcart.files.whole_file import write_whole

from .frame_names import FrameNames

FRAME_NAMES_FILE = "frames.json"
MARK_MARGIN_S = 2.0  # before and after a mark, in files of their own
PART_BYTES = 16 * 2**20  # bytes of a file
MAX_PARTS = 9  # files at most: the first, with the setting up, and the last ones
_OTHER_CLOCK = 60.0  # [s]: a stamp further off than that isn't of this clock
_BEFORE = 100_000  # frames that are held until there is a folder


class _Noted(NamedTuple):
    number: int
    time: float
    line: str


class _Line:
    """File-like object for python-can's writer that holds the last line."""

    def __init__(self) -> None:
        self.text = ""

    def write(self, text: str) -> int:
        self.text = text
        return len(text)

    def flush(self) -> None:
        """Do nothing, because the line is kept in memory."""


class FrameLog(Recording):
    """Log of every frame that is sent or received: `frames_000.log`, `frames_001.log` ..., and `frames.json`.

    A run that is resumed goes on with the next number. A file holds 16 MiB, about 350,000 frames; when there
    are more than 9, the second oldest is deleted. A received frame keeps the interface's time stamp if it is
    within 60 s of `clock`; every other frame gets the time of `clock`.
    """

    suffix = "_frames.log"

    def __init__(
        self,
        channel: str,
        clock: Callable[[], float],
        names: Callable[[], FrameNames],
        part: int = PART_BYTES,
    ) -> None:
        """Create a log that writes nothing until it has a folder.

        Args:
            channel: name of the bus in the log.
            clock: returns the time in [s], of the kind that `names` states.
            names: returns the names of nodes and PDOs; called when the bus has been set up.
            part: largest size of a file, in bytes.
        """
        self._clock, self._names, self._part = clock, names, part
        self._line = _Line()
        self._writer = CanutilsLogWriter(cast(TextIO, self._line), channel.replace(" ", "_") or "can")
        self._recent: deque[_Noted] = deque()
        self._marked: list[_Noted] = []
        self._waiting: list[str] = []
        self._folder: Path | None = None
        self._file: TextIO | None = None
        self._later = 0.0
        """Robot's time minus the clock, in [s]."""
        self._count, self._number, self._size = 0, 0, 0

    def note(self, frame: can.Message, sent: bool) -> None:
        """Record a frame, with `sent` True if this program sent it, and False if it was received."""
        now = self._clock()
        own = sent or abs(frame.timestamp - now) > _OTHER_CLOCK
        kept = copy(frame)
        kept.timestamp, kept.is_rx, kept.channel = now if own else frame.timestamp, not sent, None
        self._writer.on_message_received(kept)
        line = self._line.text
        self._recent.append(_Noted(self._count, kept.timestamp, line))
        self._count += 1
        while self._recent and self._recent[0].time < now - MARK_MARGIN_S:
            self._recent.popleft()
        if self._file is not None:
            self._write(line)
        elif self._folder is None and len(self._waiting) < _BEFORE:
            self._waiting.append(line)

    @override
    def open(self, folder: Path) -> None:
        self._folder = folder
        try:
            write_whole(folder / FRAME_NAMES_FILE, self._names().model_dump_json(indent=1) + "\n", sync=False)
            self._number = self._free_number()
            self._file = self._part_path(self._number).open("w", encoding="ascii")
        except OSError as error:
            self._give_up(error)
        for line in self._waiting:
            self._write(line)
        self._waiting = []

    @override
    def look(self, time: float) -> None:
        self._later = time - self._clock()
        if self._file is not None:
            try:
                self._file.flush()
            except OSError as error:
                self._give_up(error)

    @override
    def mark(self) -> None:
        self._marked = list(self._recent)

    @override
    def keep(self, stem: Path) -> None:
        last = self._marked[-1].number if self._marked else -1
        noted = [*self._marked, *(new for new in self._recent if new.number > last)]
        self._marked = []
        if not noted or self.lost is not None:
            return
        lines = [f"({item.time + self._later:f}){item.line.partition(')')[2]}" for item in noted]
        try:
            stem.parent.mkdir(exist_ok=True)
            write_whole(stem.with_name(stem.name + self.suffix), "".join(lines), sync=False)
        except OSError as error:
            self._give_up(error)

    @override
    def close(self) -> None:
        file, self._file = self._file, None
        if file is not None:
            with suppress(OSError):
                file.close()

    def _write(self, line: str) -> None:
        if self._file is None:
            return
        try:
            self._file.write(line)
            self._size += len(line)
            if self._size >= self._part:
                self._next_part()
        except OSError as error:
            self._give_up(error)

    def _next_part(self) -> None:
        assert self._file is not None
        self._file.close()
        self._number, self._size = self._number + 1, 0
        if self._number >= MAX_PARTS:
            self._part_path(self._number - MAX_PARTS + 1).unlink(missing_ok=True)
        self._file = self._part_path(self._number).open("w", encoding="ascii")

    def _free_number(self) -> int:
        """Return the number of the part after those of the interrupted run that is resumed; 0 for a new
        run.
        """
        assert self._folder is not None
        names = (path.stem.partition("_")[2] for path in self._folder.glob("frames_*.log"))
        return max((int(name) + 1 for name in names if name.isdecimal()), default=0)

    def _part_path(self, number: int) -> Path:
        assert self._folder is not None
        return self._folder / f"frames_{number:03d}.log"

    def _give_up(self, error: OSError) -> None:
        self.lost = error.strerror
        self.close()
