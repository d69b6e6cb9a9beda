"""Paths as messages show them."""

from __future__ import annotations

import os
from pathlib import Path


def shown_path(path: Path | str) -> str:
    """Return a path for a message: relative if it is inside the working directory, otherwise unchanged."""
    text = str(path)
    try:
        here = os.getcwd()
    except OSError:  # a working directory that was removed
        return text
    inside = os.path.join(here, "")
    return text[len(inside) :] if text.startswith(inside) and len(text) > len(inside) else text
