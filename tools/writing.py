"""Writing files where the user said."""

from __future__ import annotations

import os
from pathlib import Path

from files.errors import InputError


class NotWritable(InputError):
    """A file can't be written where the user wants it."""

    def __init__(self, path: Path, error: OSError) -> None:
        super().__init__(
            f"{path} can't be written: {error.strerror}; allowed: a file in a folder that exists"
        )


def write_text(path: Path, text: str) -> None:
    """Write a whole file or nothing: what stood there before is replaced at once.

    Raises:
        NotWritable: the folder is missing, or may not be written.
    """
    new = path.with_name(f".{path.name}.new")
    try:
        new.write_text(text, encoding="utf-8")
        os.replace(new, path)
    except OSError as error:
        new.unlink(missing_ok=True)
        raise NotWritable(path, error.strerror) from None
