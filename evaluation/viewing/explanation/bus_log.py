"""Reading of CAN logs in all formats of python-can."""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import ExitStack
from itertools import islice
from pathlib import Path

import can

from handcart.files.errors import InputError

MAX_FRAMES = 2_000_000
"""Maximum number of frames that are read from a log."""
LOG_SUFFIXES = (".asc", ".blf", ".csv", ".db", ".log", ".trc")
"""File suffixes of the log formats that python-can reads."""


class UnreadableLog(InputError):
    """Error for a file that is not a readable log of CAN frames."""

    def __init__(self, file: Path, why: object) -> None:
        super().__init__(f"{file} is not a log of CAN frames: {why}; allowed: {', '.join(LOG_SUFFIXES)}")


def read_log(file: Path) -> list[can.Message]:
    """Return all frames of a CAN log, in their order in the file.

    Raises:
        UnreadableLog: the file is missing, damaged or too long, or its suffix is not in `LOG_SUFFIXES`.
    """
    if file.suffix.lower() not in LOG_SUFFIXES:
        raise UnreadableLog(file, f"its suffix is {file.suffix!r}")
    if not file.is_file():
        raise UnreadableLog(file, "the file does not exist")
    try:
        with ExitStack() as opened:
            frames = list(islice(_reader(file, opened), MAX_FRAMES + 1))
    except Exception as error:  # the library's readers raise different errors
        raise UnreadableLog(file, f"{type(error).__name__}: {error}") from None
    if len(frames) > MAX_FRAMES:
        raise UnreadableLog(file, f"it has more than {MAX_FRAMES} frames")
    return frames


def _reader(file: Path, opened: ExitStack) -> Iterable[can.Message]:
    if file.suffix.lower() == ".blf":  # the library does not close a damaged file
        return opened.enter_context(can.BLFReader(opened.enter_context(file.open("rb"))))
    return opened.enter_context(can.LogReader(file))
