"""Test whether windows can be shown."""

from __future__ import annotations

import os
import sys

from handcart.backends.backend import NoWindow


def needs_display() -> None:
    """Raise `NoWindow` if the machine has no display on which a window could be shown."""
    if sys.platform == "linux" and not os.environ.get("DISPLAY"):
        raise NoWindow("a window needs a display: $DISPLAY is not set; allowed: --video FILE.mp4")
