"""Writing files where the user said."""

from __future__ import annotations

import os
from pathlib import Path

from handcart.files.errors import InputError
from handcart.files.whole_file import write_whole


class NotWritable(InputError):
    """Nothing can be written where the user wants it."""

    def __init__(self, path: Path, why: str | None, allowed: str = "a file in a folder that exists") -> None:
        super().__init__(f"{path} can't be written: {why}; allowed: {allowed}")


def check_folder(folder: Path) -> None:
    """Make sure, without making it, that a folder could be made, or written into where it exists.

    Raises:
        NotWritable: its nearest parent that exists is no folder, or may not be written into.
    """
    there = next(each for each in (folder, *folder.absolute().parents) if os.path.lexists(each))
    if not there.is_dir():
        raise NotWritable(folder, f"{there} is no folder", "a folder that exists or can be made")
    if not os.access(there, os.W_OK | os.X_OK):
        raise NotWritable(folder, f"{there} is closed to you", "a folder that exists or can be made")


def write_text(path: Path, text: str | bytes) -> None:
    """Write a whole file or nothing: what stood there before is replaced at once.

    Args:
        path: the file.
        text: as words, or as they are encoded already.

    Raises:
        NotWritable: the folder is missing, or may not be written.
    """
    try:
        write_whole(path.resolve(), text)
    except OSError as error:
        raise NotWritable(path, error.strerror) from None
