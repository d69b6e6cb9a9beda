"""Address of the page of a running run, noted in the run's folder for the operator's page."""

from __future__ import annotations

import re
from pathlib import Path

from handcart.files.errors import HandcartError
from handcart.files.whole_file import write_whole
from handcart.networks.run_files.run_folder import read_file

ADDRESS_FILE = "view_address"
MAX_ADDRESS_BYTES = 100
_OURS = re.compile(r"http://127\.0\.0\.1:\d{1,5}/#token=[\w-]+", re.ASCII)


def note_address(folder: Path, address: str) -> None:
    """Write a page's address, with its token, into a file that only its owner can read.

    Raises:
        OSError: the file cannot be written.
    """
    write_whole(folder / ADDRESS_FILE, address, private=True)


def forget_address(folder: Path) -> None:
    """Remove the file with a page's address from a folder, once the page is no longer served."""
    (folder / ADDRESS_FILE).unlink(missing_ok=True)


def view_address(folder: Path) -> str | None:
    """Return the address of a run's page that `note_address` wrote into a folder.

    It is None if the file is missing, or if the address in it is not one of this computer.
    """
    try:
        content = read_file(folder, ADDRESS_FILE, MAX_ADDRESS_BYTES, missing=True)
    except HandcartError:
        return None
    words = (content or b"").decode("ascii", errors="replace")
    return words if _OURS.fullmatch(words) else None
