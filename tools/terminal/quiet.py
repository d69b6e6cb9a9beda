"""Keeping what libraries say to programmers from people who use a command."""

from __future__ import annotations

import os
import sys
import warnings

_SILENT = {
    "OPENCV_LOG_LEVEL": "SILENT",  # its C++ code tells stderr of each picture that it can't read
    "OPENCV_FFMPEG_LOGLEVEL": "-8",  # as does the encoder of videos
    "PYTHONWARNINGS": "ignore",  # in processes that are begun by this one
}


def quiet_libraries() -> None:
    """Before any of them is imported; what was chosen by environment or `python -W` stays."""
    chosen = bool(sys.warnoptions)
    for name, value in _SILENT.items():
        if not (chosen and name == "PYTHONWARNINGS"):
            os.environ.setdefault(name, value)
    if not chosen:
        warnings.simplefilter("ignore")
