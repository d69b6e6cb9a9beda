"""Writing of files at paths given by the user."""

from __future__ import annotations

import os
from pathlib import Path

from handcart.files.errors import InputError
from handcart.files.shown_path import shown_path
from handcart.files.whole_file import write_whole


class NotWritable(InputError):
    """Error: a file cannot be written at the requested path."""

    def __init__(self, path: Path, why: str | None, allowed: str = "a file in a folder that exists") -> None:
        super().__init__(f"{shown_path(path)} can't be written: {why}; allowed: {allowed}")


def check_folder(folder: Path) -> None:
    """Check that a folder could be created, or files written into it if it exists, without doing so.

    Raises:
        NotWritable: its nearest existing parent is not a folder, or may not be written into.
    """
    there = next(parent for parent in (folder, *folder.absolute().parents) if os.path.lexists(parent))
    if not there.is_dir():
        raise NotWritable(folder, f"{there} is not a folder", "a folder that exists or can be made")
    if not os.access(there, os.W_OK | os.X_OK):
        raise NotWritable(folder, f"{there} is closed to you", "a folder that exists or can be made")


def write_text(path: Path, text: str | bytes) -> None:
    """Write a file completely or not at all; an existing file is replaced in one step.

    Args:
        path: the file.
        text: its content, as text or already encoded.

    Raises:
        NotWritable: the folder is missing, or may not be written.
    """
    try:
        write_whole(path.resolve(), text)
    except OSError as error:
        raise NotWritable(path, error.strerror) from None
