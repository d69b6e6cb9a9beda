"""Paths that files name: relative, portable, and never out of their root."""

import re
import unicodedata
from pathlib import Path
from typing import Annotated

from pydantic import AfterValidator

from handcart.files.errors import UnsafePath
from handcart.files.printable import printable

_LONGEST = 1024
_LONGEST_NAME = 255  # bytes that a file system takes
_REFUSED = (
    (re.compile(r"\s*"), "is empty"),
    (re.compile(r".*\\.*", re.DOTALL), "has a backslash"),
    (re.compile(r"/.*", re.DOTALL), "is absolute"),
    (re.compile(r"~.*", re.DOTALL), "starts in a home folder"),
    (re.compile(r".*:.*", re.DOTALL), "has a colon: a drive or an address"),
)


def portable(path: str) -> str:
    """Return `path` unchanged if it is a relative path on every system; otherwise raise `UnsafePath`.

    The path may still contain `..`; only `resolve_inside` can check whether the path leads out of its root.
    """
    for pattern, reason in _REFUSED:
        if pattern.fullmatch(path):
            raise UnsafePath(path[:_LONGEST], reason)
    if printable(path) != path:
        raise UnsafePath(path[:_LONGEST], "has control characters")
    if len(path) > _LONGEST:
        raise UnsafePath(f"{path[:40]}...", f"has more than {_LONGEST} characters")
    if any(len(part.encode()) > _LONGEST_NAME for part in path.split("/")):
        raise UnsafePath(f"{path[:40]}...", f"has a name of more than {_LONGEST_NAME} bytes")
    return path


FilePath = Annotated[str, AfterValidator(portable)]
"""A field of a model that names a file: a portable relative path, still to be resolved."""


def resolve_inside(root: Path, relative: str, *, start: Path | None = None) -> Path:
    """Return the absolute path of `relative` inside `root`, with every symbolic link followed.

    The file need not exist.

    Args:
        root: folder that must contain the path.
        relative: path to resolve.
        start: folder inside `root` that `relative` starts from (default: `root`).

    Raises:
        UnsafePath: the path is not a portable relative one, or leads to `root` itself or out of it, by `..`
            or by a link.
    """
    portable(relative)
    try:
        real_root = root.resolve()
        real = _written_form((start or root).resolve(), relative).resolve()
    # Python before 3.13 raises RuntimeError for a circle of links.
    except (OSError, RuntimeError, ValueError):
        raise UnsafePath(relative, "cannot be followed") from None
    if real == real_root or not real.is_relative_to(real_root):
        raise UnsafePath(relative, f"leads out of {root}")
    return real


def _written_form(folder: Path, relative: str) -> Path:
    """Return the path, in the decomposed form (NFD) of its accents if only that exists on the disk."""
    path = folder / relative
    decomposed = folder / unicodedata.normalize("NFD", relative)
    return decomposed if not path.exists() and decomposed.exists() else path
