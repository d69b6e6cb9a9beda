"""Folder for what this user's programs keep between runs."""

from __future__ import annotations

import os
from pathlib import Path


def state_folder() -> Path:
    """Return the user's folder for data that the framework keeps between runs; it need not exist.

    It is `$XDG_STATE_HOME/handcart`, by default `~/.local/state/handcart`.
    """
    home = os.environ.get("XDG_STATE_HOME")
    return (Path(home) if home else Path.home() / ".local" / "state") / "handcart"
